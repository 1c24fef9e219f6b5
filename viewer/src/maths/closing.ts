// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Threshold that closes the walls of a lumen. At one threshold for a whole scan thin walls break
// open: in CT, those of airways of 2 mm. The lumen around a position is grown value by value, as in
// region growing with explosion control [Mori2000]; its extent jumps at the value at which it leaks
// through a wall. The extent is that in blocks of 4³ voxels: noise in a lumen fills it gradually,
// but doesn't extend it. Voxels that share a corner are neighbours, so below that value no path
// through trilinear values leaks either.

import { floatOfHalf, halfOfFloat, halfOfOrder, orderOfHalf } from './half.ts';
import type { Surface } from './rays.ts';
import type { Vec3 } from './vec.ts';
import type { VolumeData } from './volume.ts';

export interface Closing {
    /// Threshold between the last value at which the lumen is closed and the next; undefined: it
    /// doesn't leak up to the present threshold.
    readonly threshold: number | undefined;
    /// Voxels of the lumen, closed.
    readonly voxels: number;
    /// Whether these are all: a lumen of more than kMost voxels is not looked at to its end.
    readonly isWhole: boolean;
}

const kStep = 0.0025; // of the range of values: 10 HU in CT
const kLeak = 2; // growth of the extent within a step that is a leak
const kBlock = 4; // voxels along a block's edge
const kLeast = 16; // blocks of a lumen below which its growth says nothing
const kMost = 8_000_000; // voxels of a lumen that are looked at

interface Grown {
    readonly value: number; ///< of the voxels that were added
    readonly voxels: number; ///< of the lumen up to it
    readonly extent: number; ///< blocks with such a voxel
}

/// Set of whole numbers.
class Bits {
    private readonly words: Uint32Array;

    constructor(count: number) {
        this.words = new Uint32Array(Math.ceil(count / 32));
    }

    /// Adds a number. @returns false: it was there
    add(n: number): boolean {
        const bit = 1 << (n & 31);
        const at = n >>> 5;
        if (this.words[at]! & bit) return false;
        this.words[at]! |= bit;
        return true;
    }
}

/// Levels in the order of values; reversed if lumens are brighter than walls.
const levelOfHalf = (half: number, rising: boolean): number =>
    rising ? orderOfHalf(half) : 0xffff - orderOfHalf(half);
const valueOfLevel = (level: number, rising: boolean): number =>
    floatOfHalf[halfOfOrder(rising ? level : 0xffff - level)]!;

/// Finds the highest threshold (with rising walls; else the lowest) at which the lumen around a
/// position does not leak.
/// @param at    voxel index in the lumen
/// @param span  range of the scan's values; of CT, 4000
/// @param most  voxels that are looked at
/// @returns undefined: there is no lumen at the present threshold
export function closingThreshold(
    { grid, halves }: VolumeData,
    { iso, rising }: Surface,
    at: Vec3,
    span: number,
    most = kMost,
): Closing | undefined {
    const [nx, ny, nz] = grid.size;
    // Values up to the threshold, or from it on, are the lumen's.
    const end = levelOfHalf(halfOfFloat(iso), rising) + (rising ? 0 : 1);
    const levelOf = (n: number): number => levelOfHalf(halves[n]!, rising);
    const around = (n: number, visit: (n: number) => void): void => {
        const i = n % nx;
        const j = ((n - i) / nx) % ny;
        const k = ((n - i) / nx - j) / ny;
        for (let z = Math.max(k - 1, 0); z <= Math.min(k + 1, nz - 1); ++z)
            for (let y = Math.max(j - 1, 0); y <= Math.min(j + 1, ny - 1); ++y)
                for (let x = Math.max(i - 1, 0); x <= Math.min(i + 1, nx - 1); ++x)
                    visit(x + nx * (y + ny * z));
    };
    const [i, j, k] = at.map((x, a) => Math.min(Math.max(Math.round(x), 0), grid.size[a]! - 1));
    const nearby: number[] = [];
    around(i! + nx * (j! + ny * k!), (n) => levelOf(n) < end && nearby.push(n));
    if (!nearby.length) return undefined;
    nearby.sort((a, b) => levelOf(a) - levelOf(b));
    const first = levelOf(nearby[nearby.length >> 1]!);

    const seen = new Bits(nx * ny * nz);
    const [bx, by, bz] = grid.size.map((n) => Math.ceil(n / kBlock)) as unknown as Vec3;
    const blocks = new Bits(bx * by * bz);
    const blockOf = (n: number): number => {
        const j = Math.floor(n / nx);
        const [x, y, z] = [n % nx, j % ny, Math.floor(j / ny)].map((v) => Math.floor(v / kBlock));
        return x! + bx * (y! + by * z!);
    };
    const waiting: (number[] | undefined)[] = new Array(end);
    let level = first;
    const meet = (n: number): void => {
        const own = Math.max(levelOf(n), level);
        if (own < end && seen.add(n)) (waiting[own] ??= []).push(n);
    };
    for (const n of nearby) meet(n);

    const grown: Grown[] = []; // after each value that occurs
    let before = 0; // index of the last one that is at least a step below
    let [voxels, extent] = [0, 0];
    for (; level < end && voxels < most; ++level) {
        const queue = waiting[level];
        if (!queue) continue;
        const value = valueOfLevel(level, rising);
        while (before + 1 < grown.length && distance(grown[before + 1]!, value) >= kStep * span)
            ++before;
        const base = grown[before]?.extent;
        const leak = base === undefined ? Infinity : kLeak * Math.max(base, kLeast);
        for (let n = queue.pop(); n !== undefined && voxels < most; n = queue.pop()) {
            ++voxels;
            if (blocks.add(blockOf(n)) && ++extent > leak)
                return leakOf([...grown.slice(before), { value, voxels, extent }]);
            around(n, meet);
        }
        grown.push({ value, voxels, extent });
        waiting[level] = undefined;
    }
    return { threshold: undefined, voxels, isWhole: voxels < most };
}

const distance = (from: Grown, value: number): number => Math.abs(value - from.value);

/// The largest growth from one value to the next.
function leakOf(steps: readonly Grown[]): Closing {
    let found = steps.length - 1;
    const growth = (n: number): number => steps[n]!.extent - steps[n - 1]!.extent;
    for (let n = found; n > 0; --n) if (growth(n) > growth(found)) found = n;
    const closed = steps[found - 1]!;
    const threshold = 0.5 * (closed.value + steps[found]!.value);
    return { threshold, voxels: closed.voxels, isWhole: true };
}
