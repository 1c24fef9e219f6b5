// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
    type Box,
    boxCount,
    isEmpty,
    voxelCount,
    voxelFromWorld,
    voxelVector,
    worldFromVoxel,
} from '../src/maths/grid.ts';
import { floatOfHalf, halfOfFloat } from '../src/maths/half.ts';
import { firstHit, type Surface } from '../src/maths/rays.ts';
import { along, dot, norm, normalized, sub, type Vec3 } from '../src/maths/vec.ts';
import { VolumeData } from '../src/maths/volume.ts';
import { randomGrid, randomVector, smoothVolume } from './fields.ts';
import { between, random, whole } from './random.ts';

interface Crossing {
    readonly t: number;
    readonly sure: boolean; ///< long enough on both sides of the wall: no method may miss it
}

/// Reference: marches in tiny steps, without bricks and root finding.
function crossings(v: VolumeData, origin: Vec3, unit: Vec3, s: Surface): Crossing[] {
    const step = 0.004;
    const least = 0.5 / norm(voxelVector(v.grid, unit)) + 2 * step;
    const turns: { t: number; above: boolean }[] = [];
    let end = 0;
    for (let t = 0; t < 90; t += step) {
        const p = voxelFromWorld(v.grid, along(origin, t, unit));
        if (!p.every((x, a) => x >= 0 && x <= v.grid.size[a]! - 1)) {
            if (turns.length) break;
            continue;
        }
        const above = v.sample(p) >= s.iso;
        if (turns[turns.length - 1]?.above !== above) turns.push({ t, above });
        end = t;
    }
    const found = turns.flatMap(({ t, above }, i) => {
        if (above !== s.rising) return [];
        const before = turns[i - 1]?.t ?? t; // a wall may be in the step that enters the volume
        const sure = t - before > least && (turns[i + 1]?.t ?? end) - t > least;
        return [{ t, sure }];
    });
    // … or in the one that leaves it.
    return [...found, { t: end + step / 2, sure: false }];
}

test('rays hit the surface where marching in tiny steps does', () => {
    let hits = 0;
    for (let i = 0; i < 120; ++i) {
        const volume = smoothVolume(randomGrid(9, 30));
        const surface = { iso: between(-700, -300), rising: random() < 0.5 };
        const start = volume.grid.size.map((n) => between(-2, n + 1)) as unknown as Vec3;
        const origin = worldFromVoxel(volume.grid, start);
        const aim = volume.grid.size.map((n) => between(0, n - 1)) as unknown as Vec3;
        const unit = normalized(sub(worldFromVoxel(volume.grid, aim), origin));
        const hit = firstHit(volume, origin, unit, surface);
        const all = crossings(volume, origin, unit, surface);
        const first = all.find((c) => c.sure)?.t ?? Infinity;
        const distance = hit?.distance ?? Infinity;
        assert.ok(!(distance > first + 0.01), `ray ${i}: hit at ${distance}, expected ${first}`);
        if (!hit) continue;
        ++hits;
        assert.ok(
            all.some((c) => Math.abs(c.t - distance) < 0.01),
            `ray ${i}: no wall there`,
        );
        const value = volume.sample(voxelFromWorld(volume.grid, hit.point));
        assert.ok(Math.abs(value - surface.iso) < 0.01);
        assert.ok(Math.abs(norm(hit.normal) - 1) < 1e-6 && dot(hit.normal, unit) <= 1e-9);
    }
    assert.ok(hits > 30, `only ${hits} rays hit`);
});

test('patched bricks are those of a new volume', () => {
    for (let i = 0; i < 30; ++i) {
        const volume = smoothVolume(randomGrid(2, 30));
        const { size } = volume.grid;
        const begin = size.map((n) => whole(0, n - 1)) as unknown as Vec3;
        const end = size.map((n, a) => whole(begin[a]! + 1, n)) as unknown as Vec3;
        const count = sub(end, begin).reduce((p, n) => p * n, 1);
        const values = Uint16Array.from({ length: count }, () => halfOfFloat(whole(-1000, 1000)));
        volume.patch({ begin, end }, values);
        const fresh = new VolumeData(volume.grid, volume.halves.slice());
        assert.deepEqual(volume.brickRange, fresh.brickRange);
        assert.deepEqual(volume.brickHalves, fresh.brickHalves);
        const [x, y, z] = begin;
        const first = volume.halves[x + size[0] * (y + size[1] * z)]!;
        assert.equal(first, values[0]);
        assert.equal(volume.valueAt(begin), floatOfHalf[first]);
    }
});

test('bricks have the smallest and the largest value of the corners of their cells', () => {
    for (let i = 0; i < 20; ++i) {
        const grid = randomGrid(1, 14);
        const halves = Uint16Array.from({ length: voxelCount(grid) }, () =>
            halfOfFloat(between(-1e4, 1e4)),
        );
        const { brickRange, brickHalves, brickSize } = new VolumeData(grid, halves);
        const [nx, ny] = grid.size;
        for (let b = 0; b < brickRange.length / 2; ++b) {
            const bx = b % brickSize[0];
            const by = Math.floor(b / brickSize[0]) % brickSize[1];
            const bz = Math.floor(b / brickSize[0] / brickSize[1]);
            const inside = (n: number, brick: number): boolean =>
                n >= 4 * brick && n <= 4 * brick + 4;
            const values = [...halves]
                .filter(
                    (_, n) =>
                        inside(n % nx, bx) &&
                        inside(Math.floor(n / nx) % ny, by) &&
                        inside(Math.floor(n / nx / ny), bz),
                )
                .map((half) => floatOfHalf[half]!);
            assert.deepEqual(
                [...brickRange.subarray(2 * b, 2 * b + 2)],
                [Math.min(...values), Math.max(...values)],
            );
            const stored = [...brickHalves.subarray(2 * b, 2 * b + 2)];
            assert.deepEqual(
                stored.map((half) => floatOfHalf[half]!),
                [...brickRange.subarray(2 * b, 2 * b + 2)],
            );
        }
    }
});

test('bricks of a scan that is being loaded are those of the whole scan, in any order', () => {
    for (let i = 0; i < 30; ++i) {
        const grid = randomGrid(2, 30);
        const { size } = grid;
        const volume = new VolumeData(grid, new Uint16Array(voxelCount(grid)), true);
        const boxes: Box[] = [];
        for (let z = 0; z < size[2]; ) {
            const end = Math.min(z + whole(1, 9), size[2]);
            const cut = whole(1, size[1] - 1);
            boxes.push({ begin: [0, 0, z], end: [size[0], cut, end] });
            boxes.push({ begin: [0, cut, z], end: [size[0], size[1], end] });
            z = end;
        }
        const inOrder = i % 2 === 0;
        if (inOrder) boxes.splice(whole(1, boxes.length), 0, boxes[0]!); // comes again
        else boxes.sort(() => whole(0, 1) - 0.5);
        for (const box of boxes) {
            const values = Uint16Array.from({ length: boxCount(box) }, () =>
                halfOfFloat(whole(-1000, 1000)),
            );
            volume.fill(box, values);
        }
        const rest = volume.finish();
        if (inOrder) assert.ok(isEmpty(rest), 'nothing is left for the end');
        const fresh = new VolumeData(grid, volume.halves.slice());
        assert.deepEqual(volume.brickRange, fresh.brickRange);
        assert.deepEqual(volume.brickHalves, fresh.brickHalves);
    }
});

test("world and voxels are each other's inverse, also on left-handed grids", () => {
    for (let i = 0; i < 100; ++i) {
        const grid = randomGrid(2, 50);
        const ijk = randomVector(60);
        const back = voxelFromWorld(grid, worldFromVoxel(grid, ijk));
        assert.ok(norm(sub(back, ijk)) < 1e-9);
    }
});
