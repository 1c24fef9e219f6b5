// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
    floatOfHalf,
    halfOfFloat,
    halfOfInt16,
    halfOfOrder,
    orderOfHalf,
} from '../src/maths/half.ts';
import { checksumOf, murmur32 } from '../src/maths/murmur.ts';
import { quantile } from '../src/net/latencies.ts';
import { between } from './random.ts';

test('every half is the nearest half of its value', () => {
    for (let bits = 0; bits < 65536; ++bits) {
        const value = floatOfHalf[bits]!;
        if (!Number.isNaN(value)) assert.equal(halfOfFloat(value), bits);
    }
});

test('halves have the order of their values', () => {
    let before = NaN;
    for (let order = 0; order < 65536; ++order) {
        const half = halfOfOrder(order);
        assert.equal(orderOfHalf(half), order);
        const value = floatOfHalf[half]!;
        if (Number.isNaN(value)) continue;
        assert.ok(!(value < before), `${value} after ${before}`);
        before = value;
    }
});

test('a number is rounded to the nearest half, ties to even', () => {
    const finite = [...floatOfHalf.keys()].filter((b) => b < 0x7c00);
    for (let i = 0; i < 20000; ++i) {
        const value = Math.fround(i % 2 ? between(0, 70) : 2 ** between(-26, 15.9));
        let best = 0;
        // Positive halves grow with their bits, so bisection finds the nearest.
        for (let step = 0x4000; step; step >>= 1)
            if (best + step < finite.length && floatOfHalf[best + step]! <= value) best += step;
        const low = floatOfHalf[best]!;
        const high = floatOfHalf[Math.min(best + 1, 0x7bff)]!;
        const up = value - low > high - value || (value - low === high - value && best % 2 === 1);
        assert.equal(halfOfFloat(value), up ? best + 1 : best, `${value}`);
        assert.equal(halfOfFloat(-value), (up ? best + 1 : best) | 0x8000);
    }
});

test('whole Hounsfield units within ±2048 are exact', () => {
    for (let hu = -2048; hu <= 2048; ++hu) assert.equal(floatOfHalf[halfOfInt16[hu & 0xffff]!], hu);
});

test('MurmurHash3 gives published values', () => {
    const hash = (text: string): number => murmur32(new TextEncoder().encode(text));
    assert.equal(hash(''), 0);
    assert.equal(hash('hello'), 0x248bfa47);
    assert.equal(hash('hello, world'), 0x149bbb7f);
    assert.equal(hash('The quick brown fox jumps over the lazy dog'), 0x2e4ff723);
});

test('a checksum has eight digits, and sees a single bit', () => {
    const halves = new Uint16Array(1001);
    const before = checksumOf(halves);
    halves[1000] = 1;
    assert.match(before, /^[0-9a-f]{8}$/);
    assert.notEqual(checksumOf(halves), before);
});

test('quantiles are values of the list', () => {
    const values = Array.from({ length: 100 }, (_, i) => (i * 37) % 100);
    assert.equal(quantile(values, 0.5), 50);
    assert.equal(quantile(values, 0.99), 99);
    assert.equal(quantile([], 0.5), undefined);
});
