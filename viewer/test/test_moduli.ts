// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The table of moduli: its axis, its values, and random edits.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
    heightOf,
    kpaAt,
    type Moduli,
    modulusAt,
    withAdded,
    withMoved,
    withoutPoint,
} from '../src/maths/moduli.ts';
import { random } from './random.ts';

const kTable: Moduli = [
    [-900, 0],
    [0, 4],
    [100, 20],
];

test('each decade of the axis has the same height, and voids are below it', () => {
    assert.equal(heightOf(0), 0);
    assert.ok(Math.abs(heightOf(10) - heightOf(1) - (heightOf(1000) - heightOf(100))) < 1e-12);
    assert.equal(heightOf(1e6), 1);
    assert.equal(kpaAt(0), 0);
    assert.equal(kpaAt(1), 1000);
    for (const kpa of [0, 0.1, 1.5, 12, 1000]) assert.equal(kpaAt(heightOf(kpa)), kpa);
});

test('moduli are linear between the points and constant beyond them', () => {
    assert.equal(modulusAt(kTable, -1000), 0);
    assert.equal(modulusAt(kTable, -450), 2);
    assert.equal(modulusAt(kTable, 75), 16);
    assert.equal(modulusAt(kTable, 3000), 20);
});

test('random edits leave ascending values and some tissue', () => {
    let moduli = kTable;
    for (let n = 0; n < 2000; ++n) {
        const at = Math.floor(random() * moduli.length);
        const point = [Math.round(2000 * random() - 1000), kpaAt(random())] as const;
        const kind = Math.floor(3 * random());
        if (kind === 0) moduli = withMoved(moduli, at, point, 10);
        else if (kind === 1) moduli = withAdded(moduli, point, 10);
        else moduli = withoutPoint(moduli, at);
        assert.ok(moduli.length > 0 && moduli.some(([, kpa]) => kpa > 0));
        for (let i = 1; i < moduli.length; ++i)
            assert.ok(moduli[i]![0] >= moduli[i - 1]![0] + 10, `step ${n}`);
    }
    assert.equal(withoutPoint([[0, 1]], 0).length, 1);
});
