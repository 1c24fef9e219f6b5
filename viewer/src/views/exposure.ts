// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Automatic exposure, metered over the picture, as in src/view/render/real_look.cpp. In front of a
// scene whose nearest wall is farther away than any in a lumen, such as an organ, the lamps are
// stronger.

import { type Camera, firstHit, rayThrough, type Surface } from '../maths/rays.ts';
import type { VolumeData } from '../maths/volume.ts';
import type { FieldStop } from '../state/state.ts';

const kAcross = 11; // rays along each side of the picture
const kKey = 0.75; // light on an average wall, as a share of its own colour
const kPower = 0.75; // exponent of the mean, between mean and median
const kNear = 5; // distance at the lowest power of the lamps [mm]
const kFar = 45; // distance at the highest power [mm]
const kLampSize = 3; // [mm]

const kCoarse = 5; // rays along each side that find the nearest wall

/// Factor of the lamps' reach in front of a scene that is far away: 1 within a lumen.
const reachFor = (nearest: number): number =>
    nearest < Infinity ? Math.max(1, nearest / kFar) : 1;

/// Factor of the lamps' reach for a camera.
export function lampReach(
    volume: VolumeData,
    camera: Camera,
    fieldOfView: number,
    barrel: number,
    aspect: number,
    surface: Surface,
): number {
    let nearest = Infinity;
    for (let j = 0; j < kCoarse; ++j)
        for (let i = 0; i < kCoarse; ++i) {
            const u = aspect * ((2 * i + 1) / kCoarse - 1);
            const v = (2 * j + 1) / kCoarse - 1;
            const ray = rayThrough(camera, fieldOfView, barrel, u, v);
            const hit = firstHit(volume, camera.eye, ray, surface);
            nearest = Math.min(nearest, hit?.distance ?? Infinity);
        }
    return reachFor(nearest);
}

const arriving = (far: number): number => 1 / (far * far + kLampSize * kLampSize);

/// Exposure for a camera [mm²].
export function meteredExposure(
    volume: VolumeData,
    camera: Camera,
    fieldOfView: number,
    barrel: number,
    aspect: number,
    surface: Surface,
    fieldStop: FieldStop,
): number {
    const full = fieldStop === 'full';
    const radius = Math.min(1, aspect);
    const [halfWidth, halfHeight] = full ? [aspect, 1] : [radius, radius];
    let sum = 0;
    let count = 0;
    let nearest = Infinity;
    for (let j = 0; j < kAcross; ++j)
        for (let i = 0; i < kAcross; ++i) {
            const u = (2 * i + 1) / kAcross - 1;
            const v = (2 * j + 1) / kAcross - 1;
            if (!full && u * u + v * v > 1) continue;
            ++count;
            const ray = rayThrough(camera, fieldOfView, barrel, halfWidth * u, halfHeight * v);
            const hit = firstHit(volume, camera.eye, ray, surface);
            if (!hit) continue;
            sum += arriving(hit.distance) ** kPower;
            nearest = Math.min(nearest, hit.distance);
        }
    const mean = (sum / count) ** (1 / kPower);
    return kKey / Math.min(Math.max(mean, arriving(kFar * reachFor(nearest))), arriving(kNear));
}
