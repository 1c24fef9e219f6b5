// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { decodeFrame } from '../src/net/protocol.ts';
import { random, whole } from './random.ts';

function boxFrame(begin: number[], count: number[], flags: number, format = 1): Uint8Array {
    const payload = 2 * count[0]! * count[1]! * count[2]!;
    const bytes = new Uint8Array(32 + payload);
    const view = new DataView(bytes.buffer);
    bytes.set(new TextEncoder().encode('PLNT'));
    view.setUint8(4, 1);
    view.setUint8(5, flags);
    view.setUint16(6, format, true);
    view.setUint32(8, 77, true);
    view.setUint32(12, 3, true);
    begin.forEach((b, a) => view.setUint16(16 + 2 * a, b, true));
    count.forEach((n, a) => view.setUint16(22 + 2 * a, n, true));
    view.setUint32(28, payload, true);
    for (let i = 0; i < payload / 2; ++i) view.setUint16(32 + 2 * i, i, true);
    return bytes;
}

test('a box has its position, its step, and its values in order', () => {
    const frame = decodeFrame(boxFrame([5, 6, 7], [2, 3, 4], 2).buffer as ArrayBuffer);
    assert.ok(frame.kind === 'box');
    assert.deepEqual(frame.box, { begin: [5, 6, 7], end: [7, 9, 11] });
    assert.equal(frame.step, 77);
    assert.equal(frame.volume, 3);
    assert.equal(frame.last, true);
    assert.equal(frame.format, 1);
    assert.deepEqual(
        [...frame.halves],
        Array.from({ length: 24 }, (_, i) => i),
    );
});

test('overlays, labels and coarse scans have their own formats, and there are no others', () => {
    for (const format of [2, 3, 5, 6]) {
        const frame = decodeFrame(boxFrame([0, 0, 0], [1, 1, 1], 0, format).buffer as ArrayBuffer);
        assert.ok(frame.kind === 'box' && frame.format === format);
    }
    for (const format of [0, 7, 257])
        assert.throws(
            () => decodeFrame(boxFrame([0, 0, 0], [1, 1, 1], 0, format).buffer as ArrayBuffer),
            /format/,
        );
});

test('a box of the rest field has four half floats for each node', () => {
    const four = boxFrame([1, 0, 2], [4, 3, 2], 2, 4);
    assert.throws(() => decodeFrame(four.buffer as ArrayBuffer), /48 bytes for 4×3×2/);
    const view = new DataView(four.buffer as ArrayBuffer);
    view.setUint16(22, 1, true); // one node of four values along x
    const frame = decodeFrame(four.buffer as ArrayBuffer);
    assert.ok(frame.kind === 'box' && frame.format === 4);
    assert.deepEqual(frame.box, { begin: [1, 0, 2], end: [2, 3, 4] });
    assert.equal(frame.halves.length, 24);
});

test('tools are read field by field', () => {
    const view = new DataView(new ArrayBuffer(32 + 80));
    [0x50, 0x4c, 0x4e, 0x54, 2].forEach((b, i) => view.setUint8(i, b));
    view.setUint16(6, 1, true);
    view.setUint32(28, 80, true);
    view.setUint32(32, 9, true);
    view.setUint8(36, 2);
    view.setUint8(37, 3);
    for (let i = 0; i < 17; ++i) view.setFloat32(40 + 4 * i, i + 0.5, true);
    const frame = decodeFrame(view.buffer);
    assert.ok(frame.kind === 'tools');
    assert.deepEqual(frame.tools, [
        {
            client: 9,
            kind: 'sphere',
            touches: true,
            limited: true,
            position: [0.5, 1.5, 2.5],
            direction: [3.5, 4.5, 5.5],
            up: [6.5, 7.5, 8.5],
            radius: 9.5,
            force_n: [10.5, 11.5, 12.5],
            energy_per_mm: [13.5, 14.5, 15.5],
            fraction: 16.5,
        },
    ]);
});

test('damaged frames are refused with a line', () => {
    let refused = 0;
    for (let i = 0; i < 5000; ++i) {
        const good = boxFrame([1, 2, 3], [whole(1, 4), whole(1, 4), whole(1, 4)], 0);
        const bytes = random() < 0.3 ? good.slice(0, whole(0, good.length - 1)) : good;
        for (let n = whole(1, 4); n > 0 && bytes.length; --n)
            bytes[whole(0, Math.min(bytes.length, 32) - 1)] = whole(0, 255);
        try {
            const frame = decodeFrame(bytes.slice().buffer as ArrayBuffer);
            if (frame.kind === 'box') {
                const { begin, end } = frame.box;
                const count = [0, 1, 2].reduce((p, a) => p * (end[a]! - begin[a]!), 1);
                assert.equal(count, frame.halves.length);
            }
        } catch (error) {
            assert.match((error as Error).message, /^(frame|box|tools|surface|vessel): [^\n]+$/);
            ++refused;
        }
    }
    assert.ok(refused > 1000);
});
