// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What fluoroscopy needs beside its shader: how bright the picture is to be. Like the machines in
// hospitals it sets its exposure by itself, from a few rays through the picture.

import { voxelFromWorld, voxelVector } from './grid.ts';
import { type Camera, rayThrough } from './rays.ts';
import { along, norm, type Vec3 } from './vec.ts';
import type { VolumeData } from './volume.ts';

export const kWaterPerMm = 0.02; ///< absorption of water at about 60 keV [1/mm]
const kRays = 7; // along each side of the central third of the picture
const kSamples = 192; // of each

/// ∫ max(0, 1 + HU/1000) along a ray [mm of water].
export function waterAlong(volume: VolumeData, eye: Vec3, ray: Vec3, samples = kSamples): number {
    const o = voxelFromWorld(volume.grid, eye);
    const d = voxelVector(volume.grid, ray);
    let begin = 0;
    let end = Infinity;
    for (let a = 0; a < 3; ++a) {
        const last = volume.grid.size[a]! - 1;
        if (d[a] === 0) {
            if (o[a]! < 0 || o[a]! > last) return 0;
            continue;
        }
        const t0 = (0 - o[a]!) / d[a]!;
        const t1 = (last - o[a]!) / d[a]!;
        begin = Math.max(begin, Math.min(t0, t1));
        end = Math.min(end, Math.max(t0, t1));
    }
    if (!(end > begin)) return 0;
    const step = (end - begin) / samples;
    let sum = 0;
    for (let n = 0; n < samples; ++n)
        sum += Math.max(0, 1 + volume.sample(along(o, begin + (n + 0.5) * step, d)) / 1000);
    return sum * step * norm(ray);
}

/// Median over rays through the central third of the picture, without those that miss the scan
/// [mm of water].
export function usualWater(
    volume: VolumeData,
    camera: Camera,
    fieldOfView: number,
    aspect: number,
): number {
    const found: number[] = [];
    for (let i = 0; i < kRays; ++i)
        for (let j = 0; j < kRays; ++j) {
            const u = (aspect * ((2 * (i + 0.5)) / kRays - 1)) / 3;
            const v = ((2 * (j + 0.5)) / kRays - 1) / 3;
            const water = waterAlong(volume, camera.eye, rayThrough(camera, fieldOfView, 0, u, v));
            if (water > 1) found.push(water);
        }
    found.sort((a, b) => a - b);
    return found[Math.floor(found.length / 2)] ?? 0;
}
