// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tables of the real look. test_picture.ts compares the pictures with the C++ renderer's.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { floatOfHalf } from '../src/maths/half.ts';
import { kLinings } from '../src/state/state.ts';
import { kColours } from '../src/views/linings.ts';
import { noiseTile } from '../src/views/noise.ts';
import { kFolder } from './browser.ts';

// tests/render/test_real_look.cpp has the same numbers.
test('the noise tile is that of the C++ renderer', () => {
    const tile = noiseTile();
    const at = (i: number, j: number, k: number): number[] => {
        const begin = 4 * ((k * 64 + j) * 64 + i);
        return [...tile.subarray(begin, begin + 4)].map((half) => floatOfHalf[half]!);
    };
    const near = (a: number, b: number): void =>
        assert.ok(Math.abs(a - b) < 1e-3 * Math.abs(b), `${a}, expected ${b}`);
    assert.ok(
        at(0, 0, 0)
            .slice(0, 3)
            .every((slope) => slope === 0),
    );
    near(at(0, 0, 0)[3]!, 0.068359375);
    near(at(5, 22, 63)[3]!, 0.35149574279785156);
    near(at(5, 22, 63)[0]!, 0.00611114501953125);
});

test('the colours of each lining are those of the C++ renderer', () => {
    // lining.h has one block per lining, .snake_case = number or {r, g, b}; the last is for the
    // airway.
    const text = readFileSync(join(kFolder, '../src/view/render/lining.h'), 'utf8');
    for (const lining of kLinings) {
        const name = lining[0]!.toUpperCase() + lining.slice(1);
        const block = /return \{(.*?)\};/s.exec(text.slice(text.indexOf(`case Lining::${name}:`)));
        const fields = [...block![1]!.matchAll(/\.(\w+) = (\{[^}]*\}|[\d.]+)/g)].map(
            ([, field, value]) => [
                field!.replace(/_(\w)/g, (_, letter: string) => letter.toUpperCase()),
                JSON.parse(value!.replace('{', '[').replace('}', ']')) as number | number[],
            ],
        );
        assert.equal(fields.length, 12, lining);
        assert.deepEqual(Object.fromEntries(fields), kColours[lining], lining);
    }
});
