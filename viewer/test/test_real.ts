// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Numbers behind the real look. The pictures are compared with the C++ renderer's in
// test_picture.ts.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { floatOfHalf } from '../src/half.ts';
import { noiseTile } from '../src/noise.ts';

// tests/render/test_real_look.cpp has the same numbers.
test('the tile of noise is the one of the C++ renderer', () => {
    const tile = noiseTile();
    const at = (i: number, j: number, k: number): number[] => {
        const begin = 4 * ((k * 64 + j) * 64 + i);
        return [...tile.subarray(begin, begin + 4)].map((half) => floatOfHalf[half]!);
    };
    const near = (a: number, b: number): void =>
        assert.ok(Math.abs(a - b) < 1e-3 * Math.abs(b), `${a}, expected ${b}`);
    assert.ok(at(0, 0, 0).slice(0, 3).every((slope) => slope === 0));
    near(at(0, 0, 0)[3]!, 0.068359375);
    near(at(5, 22, 63)[3]!, 0.35149574279785156);
    near(at(5, 22, 63)[0]!, 0.00611114501953125);
});
