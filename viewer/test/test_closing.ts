// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The threshold that closes a lumen's walls, against floods at single thresholds.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { closingThreshold } from '../src/maths/closing.ts';
import type { Grid } from '../src/maths/grid.ts';
import { floatOfHalf, halfOfFloat } from '../src/maths/half.ts';
import type { Vec3 } from '../src/maths/vec.ts';
import { VolumeData } from '../src/maths/volume.ts';
import { whole } from './random.ts';

const kSpan = 4000; // [HU]

function volumeOf(size: Vec3, value: (i: number, j: number, k: number) => number): VolumeData {
    const [nx, ny, nz] = size;
    const grid: Grid = {
        size,
        spacing: [1, 1, 1],
        origin: [0, 0, 0],
        direction: [1, 0, 0, 0, 1, 0, 0, 0, 1],
    } as never;
    const halves = new Uint16Array(nx * ny * nz);
    for (let n = 0; n < halves.length; ++n) {
        const i = n % nx;
        const j = Math.floor(n / nx) % ny;
        halves[n] = halfOfFloat(value(i, j, Math.floor(n / (nx * ny))));
    }
    return new VolumeData(grid, halves);
}

/// Voxels with a value for which `is` holds that are connected with one, also over corners.
function flood({ grid, halves }: VolumeData, at: Vec3, is: (value: number) => boolean): number {
    const [nx, ny, nz] = grid.size;
    const found = new Uint8Array(halves.length);
    const open: Vec3[] = [at];
    for (let p = open.pop(); p; p = open.pop()) {
        const [i, j, k] = p;
        if (i < 0 || j < 0 || k < 0 || i >= nx || j >= ny || k >= nz) continue;
        const n = i + nx * (j + ny * k);
        if (found[n] || !is(floatOfHalf[halves[n]!]!)) continue;
        found[n] = 1;
        for (let m = 0; m < 27; ++m)
            open.push([
                i - 1 + (m % 3),
                j - 1 + (Math.floor(m / 3) % 3),
                k - 1 + Math.floor(m / 9),
            ]);
    }
    return found.reduce((sum, one) => sum + one, 0);
}

/// An airway of 9×9×40 voxels in lung, in a wall of one voxel with a thin place.
const kAirway: Vec3 = [24, 24, 40];
const airway = (thin: number, lung: () => number) => (i: number, j: number, k: number) => {
    const from = Math.max(Math.abs(i - 11), Math.abs(j - 11));
    if (from <= 4) return -1000 + whole(0, 15);
    if (from > 5) return lung();
    return i === 16 && j === 9 && k === 17 ? thin : -400 + whole(0, 100);
};

test('an airway is closed just below the value of the thinnest place of its wall', () => {
    for (const sign of [1, -1]) {
        const value = airway(-704, () => -860 + whole(0, 20));
        const volume = volumeOf(kAirway, (i, j, k) => sign * value(i, j, k));
        const surface = { iso: sign * -500, rising: sign > 0 };
        const at: Vec3 = [11, 11, 20];
        const found = closingThreshold(volume, surface, at, kSpan)!;
        // The values in front of it are those of the lumen.
        const middle = 0.5 * (-985 - 704);
        assert.ok(Math.abs(sign * found.threshold! - middle) <= 8, `${found.threshold}`);
        assert.equal(found.voxels, 9 * 9 * 40);
        const below = (threshold: number) => (x: number) => sign * (x - threshold) < 0;
        assert.equal(flood(volume, at, below(found.threshold!)), found.voxels);
        assert.ok(flood(volume, at, (x) => sign * x <= -704) > 20_000, 'it leaks there');
    }
});

test('a wall that holds, and a place in the wall', () => {
    const volume = volumeOf(
        kAirway,
        airway(-450, () => -850),
    );
    const surface = { iso: -500, rising: true };
    const closed = closingThreshold(volume, surface, [11.4, 10.7, 20], kSpan)!;
    assert.deepEqual(closed, { threshold: undefined, voxels: 9 * 9 * 40, isWhole: true });
    const partial = closingThreshold(volume, surface, [11, 10, 20], kSpan, 500)!;
    assert.deepEqual(partial, { threshold: undefined, voxels: 500, isWhole: false });
    const dense = volumeOf([8, 8, 8], () => 40);
    assert.equal(closingThreshold(dense, surface, [3, 3, 3], kSpan), undefined);
});

test('random walls are closed at the value before the flood jumps', () => {
    for (let round = 0; round < 20; ++round) {
        const thin = whole(-800, -550);
        const value = airway(thin, () => whole(-900, -820));
        const noisy = volumeOf(kAirway, value);
        const at: Vec3 = [11, 11, whole(5, 35)];
        const found = closingThreshold(noisy, { iso: -500, rising: true }, at, kSpan)!;
        const sizes = [-1, 1].map((way) =>
            flood(noisy, at, (x) => x < found.threshold! || (way > 0 && x <= thin)),
        );
        assert.equal(sizes[0], found.voxels);
        assert.ok(sizes[1]! > 2 * sizes[0]!, `${sizes} at ${thin}`);
        const higher = 0.5 * (found.threshold! + thin);
        assert.equal(flood(noisy, at, (x) => x < higher), found.voxels, 'no value between leaks');
    }
});
