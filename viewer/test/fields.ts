// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Small random volumes on random grids, oblique and left-handed ones among them.

import type { Grid } from '../src/maths/grid.ts';
import { halfOfFloat } from '../src/maths/half.ts';
import { cross, normalized, type Vec3 } from '../src/maths/vec.ts';
import { VolumeData } from '../src/maths/volume.ts';
import { between, random, whole } from './random.ts';

export const randomVector = (size: number): Vec3 => [
    between(-size, size),
    between(-size, size),
    between(-size, size),
];

export function randomGrid(low: number, high: number): Grid {
    const i = normalized(randomVector(1));
    const j = normalized(cross(i, randomVector(1)));
    const k = cross(i, j);
    return {
        size: [whole(low, high), whole(low, high), whole(low, high)],
        spacing: [between(0.5, 2), between(0.5, 2), between(0.5, 2)],
        origin: randomVector(200),
        direction: [i, j, random() < 0.5 ? k : [-k[0], -k[1], -k[2]]],
    };
}

/// Volume of smooth bumps: walls are thicker than the rays' step.
export function smoothVolume(grid: Grid): VolumeData {
    const [nx, ny, nz] = grid.size;
    const waves = Array.from({ length: 5 }, () => ({
        k: randomVector(0.35),
        phase: between(0, 7),
        height: between(100, 500),
    }));
    const halves = new Uint16Array(nx * ny * nz);
    let at = 0;
    for (let z = 0; z < nz; ++z)
        for (let y = 0; y < ny; ++y)
            for (let x = 0; x < nx; ++x) {
                let value = -500;
                for (const { k, phase, height } of waves)
                    value += height * Math.sin(k[0] * x + k[1] * y + k[2] * z + phase);
                halves[at++] = halfOfFloat(Math.round(value));
            }
    return new VolumeData(grid, halves);
}
