// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parameters of the fluoroscopy shader: the range of its rays, and the exposure. As in clinical
// systems, the exposure is automatic, from a few rays through the picture. Formulas:
// include/pliant/render.h.

import { type Grid, voxelFromWorld, voxelVector, worldFromVoxel } from '../maths/grid.ts';
import { type Camera, rayThrough } from '../maths/rays.ts';
import { along, dot, mul, norm, normalized, sub, type Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';

export const kWaterPerMm = 0.02; ///< absorption of water at about 60 keV [1/mm]
const kBorderShare = 1 / 3;
const kRays = 7; // along each side of the central third of the picture
const kSamples = 192; // per ray

/// Planes across the view that bound the rays, and the border in which the outermost voxels fade
/// out.
export interface Projection {
    readonly ahead: Vec3; ///< unit vector
    readonly slab: readonly [number, number]; ///< distances of the planes from the eye [mm]
    readonly margin: Vec3; ///< width of the border [voxels]
}

/// Projection for a camera: the planes touch the scan, and the border is a third of the cube root
/// of its volume.
export function projectionOf(grid: Grid, camera: Camera): Projection {
    const ahead = normalized(camera.look);
    const last = grid.size.map((n) => n - 1) as unknown as Vec3;
    const middle = dot(sub(worldFromVoxel(grid, mul(0.5, last)), camera.eye), ahead);
    let half = 0;
    let volume = 1;
    for (let a = 0; a < 3; ++a) {
        const side = last[a]! * grid.spacing[a]!;
        const axis = grid.direction.map((row) => row[a]!) as unknown as Vec3;
        half += 0.5 * side * Math.abs(dot(axis, ahead));
        volume *= side;
    }
    const border = kBorderShare * Math.cbrt(volume);
    const margin = grid.spacing.map((mm) => border / mm) as unknown as Vec3;
    return { ahead, slab: [middle - half, middle + half], margin };
}

/// Weight of the outermost voxels at p [voxels]; 1 in the scan.
function leftAt(p: Vec3, size: Vec3, margin: Vec3): number {
    let e2 = 0;
    for (let a = 0; a < 3; ++a) {
        const beyond = p[a]! - Math.min(Math.max(p[a]!, 0), size[a]! - 1);
        if (beyond !== 0) e2 += (beyond / margin[a]!) ** 2;
    }
    return Math.max(0, 1 - e2) ** 2;
}

/// Integral of max(0, 1 + HU/1000) along a ray [mm of water].
export function waterAlong(
    volume: VolumeData,
    eye: Vec3,
    ray: Vec3,
    { ahead, slab, margin }: Projection,
    samples = kSamples,
): number {
    const { size } = volume.grid;
    const o = voxelFromWorld(volume.grid, eye);
    const d = voxelVector(volume.grid, ray);
    const part = dot(ray, ahead);
    let begin = Math.max(0, slab[0] / part);
    let end = slab[1] / part;
    for (let a = 0; a < 3; ++a) {
        const first = -margin[a]!;
        const last = size[a]! - 1 + margin[a]!;
        if (d[a] === 0) {
            if (o[a]! < first || o[a]! > last) return 0;
            continue;
        }
        const t0 = (first - o[a]!) / d[a]!;
        const t1 = (last - o[a]!) / d[a]!;
        begin = Math.max(begin, Math.min(t0, t1));
        end = Math.min(end, Math.max(t0, t1));
    }
    if (!(end > begin)) return 0;
    const step = (end - begin) / samples;
    let sum = 0;
    for (let n = 0; n < samples; ++n) {
        const p = along(o, begin + (n + 0.5) * step, d);
        sum += leftAt(p, size, margin) * Math.max(0, 1 + volume.sample(p) / 1000);
    }
    return sum * step * norm(ray);
}

/// Median of waterAlong over rays through the central third of the picture that hit the scan
/// [mm of water].
export function usualWater(
    volume: VolumeData,
    camera: Camera,
    fieldOfView: number,
    aspect: number,
): number {
    const projection = projectionOf(volume.grid, camera);
    const found: number[] = [];
    for (let i = 0; i < kRays; ++i)
        for (let j = 0; j < kRays; ++j) {
            const u = (aspect * ((2 * (i + 0.5)) / kRays - 1)) / 3;
            const v = ((2 * (j + 0.5)) / kRays - 1) / 3;
            const ray = rayThrough(camera, fieldOfView, 0, u, v);
            const water = waterAlong(volume, camera.eye, ray, projection);
            if (water > 1) found.push(water);
        }
    found.sort((a, b) => a - b);
    return found[Math.floor(found.length / 2)] ?? 0;
}
