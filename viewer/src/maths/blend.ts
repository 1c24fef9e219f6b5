// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One ray of the volume rendering in the page's mirror of the voxels: the equations of
// src/view/render/blend.h and shaders/blend.frag.glsl, in steps of half a voxel, without skipping.
// For picking, and as a reference.

import { voxelFromWorld, voxelVector } from './grid.ts';
import { steepOf, type Transfer, transferAt } from './transfer.ts';
import { along, apply, dot, norm, normalized, type Vec3 } from './vec.ts';
import type { VolumeData } from './volume.ts';

const kDark = 1e-3; // rays end below this transmittance
const kAmbient = 0.35;
const kPicked = 0.5; // transmittance at a picked point

export interface Blended {
    readonly light: Vec3; ///< linear, without the background
    readonly transmittance: number;
    readonly picked: Vec3 | undefined; ///< where half of the background's light is left [mm, LPS]
}

/// Light along a ray.
/// @param direction  [mm, LPS], any length > 0
/// @param offset  position of the samples in their steps, 0…1
export function blendAlong(
    volume: VolumeData,
    transfer: Transfer,
    origin: Vec3,
    direction: Vec3,
    offset = 0.5,
): Blended {
    const { grid } = volume;
    const unit = normalized(direction);
    const o = voxelFromWorld(grid, origin);
    const d = voxelVector(grid, unit);
    let light: Vec3 = [0, 0, 0];
    let transmittance = 1;
    let picked: Vec3 | undefined;
    const [begin, end] = stretchIn(grid.size, o, d);
    const count = end > begin ? Math.ceil((end - begin) / (0.5 * Math.min(...grid.spacing))) : 0;
    const step = (end - begin) / count;
    for (let i = 0; i < count && transmittance >= kDark; ++i) {
        const t = begin + (i + offset) * step;
        const p = along(o, t, d);
        const { perMm, light: own } = transferAt(transfer, volume.sample(p));
        if (!perMm) continue;
        const opacity = 1 - Math.exp(-perMm * step);
        const share = transmittance * opacity * shadeAt(volume, p, unit, steepOf(transfer));
        light = along(light, share, own);
        transmittance *= 1 - opacity;
        if (transmittance < kPicked) picked ??= along(origin, t, unit);
    }
    return { light, transmittance, picked };
}

/// Range of a ray between the outermost voxel centres [mm].
function stretchIn(size: Vec3, o: Vec3, d: Vec3): [number, number] {
    let begin = 0;
    let end = Infinity;
    for (let a = 0; a < 3; ++a) {
        const last = size[a]! - 1;
        if (d[a] === 0) {
            if (o[a]! < 0 || o[a]! > last) return [0, 0];
            continue;
        }
        const t0 = -o[a]! / d[a]!;
        const t1 = (last - o[a]!) / d[a]!;
        begin = Math.max(begin, Math.min(t0, t1));
        end = Math.min(end, Math.max(t0, t1));
    }
    return [begin, end];
}

/// Brightness of a sample, less where a steep gradient is perpendicular to the ray.
function shadeAt(volume: VolumeData, p: Vec3, ray: Vec3, steep: number): number {
    const { direction, spacing } = volume.grid;
    const g = volume.gradient(p).map((x, a) => x / spacing[a]!) as unknown as Vec3;
    const world = apply(direction, g);
    const steepness = norm(world);
    if (!(steepness > 0)) return 1;
    const facing = Math.abs(dot(world, ray)) / steepness;
    return 1 - Math.min(1, steepness / steep) * (1 - kAmbient) * (1 - facing);
}
