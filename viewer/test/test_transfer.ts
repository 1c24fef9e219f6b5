// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { blendAlong } from '../src/maths/blend.ts';
import { halfOfFloat } from '../src/maths/half.ts';
import { levelsOf } from '../src/maths/levels.ts';
import {
    adjusted,
    emptyRanges,
    kCtPresets,
    kLevelPresets,
    kMaxPoints,
    linearOf,
    rampOf,
    type Transfer,
    transferAt,
} from '../src/maths/transfer.ts';
import { VolumeData } from '../src/maths/volume.ts';
import { random, whole } from './random.ts';

const near = (a: number, b: number, off = 1e-9): void =>
    assert.ok(Math.abs(a - b) <= off, `${a}, expected ${b}`);

const levels = { low: 0, threshold: 1000, bright: 3000, high: 4000 };
const all = [...kCtPresets, ...kLevelPresets].map(({ transferOf }) => transferOf(() => levels));

test('a ramp has the extinction and the colour of the C++ renderer', () => {
    const ramp = rampOf(-100, 400, 0.25, [150, 60, 40], [255, 250, 240]);
    for (const [value, share] of [
        [-500, 0],
        [-100, 0],
        [25, 0.25],
        [400, 1],
        [3000, 1],
    ] as const) {
        const { perMm, light } = transferAt(ramp, value);
        near(perMm, 0.25 * share);
        near(light[1], (1 - share) * linearOf(60) + share * linearOf(250));
    }
});

test('adjusting multiplies extinctions and moves values', () => {
    const moved = adjusted(rampOf(0, 100, 0.5), 3, 20);
    near(transferAt(moved, 70).perMm, 0.75);
    near(transferAt(moved, 20).perMm, 0);
});

test('empty ranges are the values without extinction, for random transfer functions', () => {
    for (let n = 0; n < 300; ++n) {
        const count = whole(1, kMaxPoints);
        const values = Array.from({ length: count }, () => whole(0, 20)).sort(
            (a, b) => a - b,
        );
        const transfer: Transfer = values.map((value) => ({
            value,
            perMm: random() < 0.5 ? 0 : random(),
            colour: [0, 0, 0],
        }));
        const ranges = emptyRanges(transfer);
        assert.ok(ranges.length <= 4);
        for (let v = -1.75; v < 22; v += 0.5) {
            const inRange = ranges.some(([low, high]) => v >= low && v <= high);
            const empty = transferAt(transfer, v).perMm === 0;
            assert.equal(inRange, empty, `${v} in ${JSON.stringify(transfer)}`);
        }
    }
});

test('presets have ascending values, and few enough points', () => {
    for (const transfer of all) {
        assert.ok(transfer.length <= kMaxPoints);
        transfer.forEach((p, i) => assert.ok(i === 0 || p.value > transfer[i - 1]!.value));
        assert.ok(transfer.some(({ perMm }) => perMm > 0));
    }
});

test('levels of two classes: the threshold lies between them', () => {
    const values = Array.from({ length: 20000 }, (_, i) =>
        i % 4 ? 20 * random() : 800 + 400 * random(),
    );
    const found = levelsOf(Uint16Array.from(values, halfOfFloat));
    assert.ok(found.low < 5, `low ${found.low}`);
    assert.ok(found.threshold >= 20 && found.threshold < 800, `threshold ${found.threshold}`);
    near(found.bright, 1160, 10);
    near(found.high, 1198, 4);
});

test('levels of a uniform scan are its value', () => {
    const found = levelsOf(new Uint16Array(64).fill(halfOfFloat(7)));
    assert.deepEqual(found, { low: 7, threshold: 7, bright: 7, high: 7 });
});

/// Cube of 9³ voxels of 2 mm with one value.
const uniform = (value: number): VolumeData =>
    new VolumeData(
        {
            size: [9, 9, 9],
            spacing: [2, 2, 2],
            origin: [0, 0, 0],
            direction: [
                [1, 0, 0],
                [0, 1, 0],
                [0, 0, 1],
            ],
        },
        new Uint16Array(729).fill(halfOfFloat(value)),
    );

test('a uniform medium absorbs by the law of Beer and Lambert', () => {
    const transfer = rampOf(0, 100, 0.2);
    const seen = blendAlong(uniform(50), transfer, [8, 8, -30], [0, 0, 3]);
    near(seen.transmittance, Math.exp(-0.1 * 16), 1e-6);
    const own = transferAt(transfer, 50).light;
    near(seen.light[0], (1 - seen.transmittance) * own[0], 1e-6);
    const half = Math.log(2) / 0.1;
    near(seen.picked![2], half, 1);
    assert.deepEqual(seen.picked!.slice(0, 2), [8, 8]);
});

test('rays beside the scan, and through values without extinction, see nothing', () => {
    const transfer = rampOf(0, 100, 0.2);
    for (const seen of [
        blendAlong(uniform(50), transfer, [8, 30, -30], [0, 0, 1]),
        blendAlong(uniform(-1), transfer, [8, 8, -30], [0, 0, 1]),
    ])
        assert.deepEqual(seen, { light: [0, 0, 0], transmittance: 1, picked: undefined });
});

test('skin is as bright wherever its surface lies between voxels', () => {
    const skin = kCtPresets.find(({ name }) => name === 'skin')!.transferOf(() => levels);
    const spread = (transfer: Transfer): number => {
        const seen = Array.from({ length: 11 }, (_, n) => {
            const volume = uniform(40);
            const at = (k: number): number => (k < 2 ? -1000 : k === 2 ? -1000 + 104 * n : 40);
            for (let k = 0; k < 9; ++k) volume.halves.fill(halfOfFloat(at(k)), 81 * k, 81 * k + 81);
            return blendAlong(volume, transfer, [8, 8, -30], [0, 0, 1]).light[1];
        });
        return Math.max(...seen) / Math.min(...seen) - 1;
    };
    assert.ok(spread(skin) < 0.02, `${spread(skin)}`);
    const ramp = rampOf(-650, -50, 0.8, [196, 132, 104], [240, 200, 172]);
    assert.ok(spread(ramp) > 0.05, `a ramp of colours: ${spread(ramp)}`);
});
