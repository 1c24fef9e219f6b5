// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Colour maps, made in Oklab, against an independent colour space (CIE Lab); ranges of overlays;
// storage of presets.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { kColours, kDiverging, kRising } from '../src/maths/colour_map.ts';
import { floatOfHalf, halfOfFloat } from '../src/maths/half.ts';
import { norm, sub, type Vec3 } from '../src/maths/vec.ts';
import type { Memory } from '../src/net/connection.ts';
import { PresetShelf } from '../src/panels/own_presets.ts';
import { type Range, rangeOf, roundReach, type ShownKind } from '../src/state/overlay_kinds.ts';
import { initialState } from '../src/state/state.ts';
import { OverlayField } from '../src/views/overlay_field.ts';
import { randomGrid } from './fields.ts';
import { between, random, whole } from './random.ts';

/// CIE 1976 L*a*b*, D65.
function labOf(srgb: Vec3): Vec3 {
    const [r, g, b] = srgb.map((x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4));
    const f = (t: number): number =>
        t > (6 / 29) ** 3 ? Math.cbrt(t) : t / (3 * (6 / 29) ** 2) + 4 / 29;
    const x = f((0.4124 * r! + 0.3576 * g! + 0.1805 * b!) / 0.9505);
    const y = f(0.2126 * r! + 0.7152 * g! + 0.0722 * b!);
    const z = f((0.0193 * r! + 0.1192 * g! + 0.9505 * b!) / 1.089);
    return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

test('the sequential map grows lighter at nearly one rate', () => {
    assert.equal(kRising.length, kColours);
    const labs = kRising.map(labOf);
    const steps = labs.slice(1).map((lab, i) => lab[0] - labs[i]![0]);
    const mean = (labs[kColours - 1]![0] - labs[0]![0]) / (kColours - 1);
    assert.ok(mean > 4, `${mean} L* per colour`);
    for (const step of steps) assert.ok(step > 0.7 * mean && step < 1.35 * mean, `${step}`);
    const ways = labs.slice(1).map((lab, i) => norm(sub(lab, labs[i]!)));
    assert.ok(Math.max(...ways) < 3 * Math.min(...ways), ways.map((w) => w.toFixed(1)).join(' '));
});

test('the diverging map is grey in the middle, symmetric in lightness, and has two hues', () => {
    const labs = kDiverging.map(labOf);
    const middle = labs[(kColours - 1) / 2]!;
    assert.ok(Math.hypot(middle[1], middle[2]) < 3 && middle[0] > 85);
    for (let i = 0; i < (kColours - 1) / 2; ++i) {
        const left = labs[i]!;
        const right = labs[kColours - 1 - i]!;
        assert.ok(Math.abs(left[0] - right[0]) < 8, `${left[0]} ${right[0]}`);
        assert.ok(left[0] < labs[i + 1]![0]);
        assert.ok(left[2] < right[2] && left[1] < right[1]); // blue, red
    }
});

test('a range ends at 1, 2 or 5 times a power of ten just beyond the values', () => {
    for (let i = 0; i < 2000; ++i) {
        const value = 10 ** between(-3, 3);
        const reach = roundReach(value);
        assert.ok(reach >= value * 0.999999 && reach <= 2.5 * value, `${value} ${reach}`);
        assert.match(reach.toExponential(), /^[125]e/);
    }
    const ranged = (kind: ShownKind, extreme: number, auto = true): Range => {
        const { scan, overlay } = initialState();
        return rangeOf({ scan: { ...scan, extreme }, overlay: { ...overlay, kind, auto } });
    };
    assert.deepEqual(ranged('jacobian', 0.13), { low: 0.8, high: 1.2 });
    assert.deepEqual(ranged('jacobian', 40), { low: 0, high: 2 });
    assert.deepEqual(ranged('jacobian', 0.13, false), { low: 0.5, high: 1.5 });
    assert.deepEqual(ranged('displacement', 7.2), { low: 0, high: 10 });
});

test('the field holds random patches and knows the largest departure', () => {
    for (const kind of ['displacement', 'jacobian'] as const)
        for (let round = 0; round < 8; ++round) {
            const grid = randomGrid(3, 30);
            const [nx, ny, nz] = grid.size;
            const field = new OverlayField(kind, grid);
            const rest = kind === 'jacobian' ? 1 : 0;
            const truth = new Float64Array(nx * ny * nz).fill(rest);
            assert.equal(field.extreme, 0);
            for (let n = 0; n < 12; ++n) {
                const begin = grid.size.map((s) => whole(0, s - 1));
                const end = grid.size.map((s, a) => whole(begin[a]! + 1, s));
                const values: number[] = [];
                for (let k = begin[2]!; k < end[2]!; ++k)
                    for (let j = begin[1]!; j < end[1]!; ++j)
                        for (let i = begin[0]!; i < end[0]!; ++i) {
                            const half = halfOfFloat(random() < 0.5 ? rest : between(-3, 9));
                            values.push(half);
                            truth[i + nx * (j + ny * k)] = floatOfHalf[half]!;
                        }
                field.patch(
                    { begin: begin as unknown as Vec3, end: end as unknown as Vec3 },
                    Uint16Array.from(values),
                );
                const most = truth.reduce((m, x) => Math.max(m, Math.abs(x - rest)), 0);
                assert.ok(Math.abs(field.extreme - most) < 1e-6);
            }
            for (let n = 0; n < 100; ++n) {
                const at = grid.size.map((s) => between(-1, s)) as unknown as Vec3;
                const [i, j, k] = at.map(Math.round);
                const inside = [i, j, k].every((x, a) => x! >= 0 && x! < grid.size[a]!);
                assert.equal(
                    field.valueAt(at),
                    inside ? truth[i! + nx * (j! + ny * k!)] : undefined,
                );
            }
        }
});

const memoryOf = (text?: string): Memory & { text: string | null } => ({
    text: text ?? null,
    getItem() {
        return this.text;
    },
    setItem(_, value) {
        this.text = value;
    },
});
const isNumber = (value: unknown): value is number => typeof value === 'number';

test('presets are stored, replaced, deleted and sorted by name', () => {
    const memory = memoryOf();
    const shelf = new PresetShelf(memory, 'key', isNumber);
    assert.equal(shelf.save(' Nodule ', 3), undefined);
    assert.equal(shelf.save('Fat', 4), undefined);
    assert.equal(shelf.save('Nodule', 5), undefined);
    assert.match(shelf.save('  ', 5)!, /name/);
    const wanted = [
        { text: 'Fat', value: 4 },
        { text: 'Nodule', value: 5 },
    ];
    assert.deepEqual(shelf.presets, wanted);
    assert.deepEqual(new PresetShelf(memory, 'key', isNumber).presets, wanted);
    shelf.remove('Fat');
    assert.deepEqual(new PresetShelf(memory, 'key', isNumber).presets, [wanted[1]]);
    for (let n = 0; n < 49; ++n) assert.equal(shelf.save(`p${n}`, n), undefined);
    assert.match(shelf.save('one more', 1)!, /50/);
    assert.equal(shelf.save('p7', 8), undefined);
});

test('invalid stored presets are ignored, and a full storage is reported', () => {
    const invalid = ['', 'null', '{', '7', '{"a":1}', '[1,null,"x",{"text":3}]', '[{"value":1}]'];
    for (const text of invalid)
        assert.deepEqual(new PresetShelf(memoryOf(text), 'key', isNumber).presets, []);
    const mixed = '[{"text":"a","value":"x"},{"text":"b","value":2},{"text":"","value":3}]';
    const shelf = new PresetShelf(memoryOf(mixed), 'key', isNumber);
    assert.deepEqual(shelf.presets, [{ text: 'b', value: 2 }]);
    const full: Memory = {
        getItem: () => null,
        setItem: () => {
            throw new Error('QuotaExceededError');
        },
    };
    assert.match(new PresetShelf(full, 'key', isNumber).save('a', 1)!, /stores nothing/);
});
