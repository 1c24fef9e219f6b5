// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Geometry and files of marks and of the lumen's sections, without a browser.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { type Grid, voxelCount, worldFromVoxel } from '../src/maths/grid.ts';
import { halfOfFloat } from '../src/maths/half.ts';
import { crossSection, type CrossSection, sectionsAlong } from '../src/maths/lumen.ts';
import {
    angleOf,
    freeName,
    lengthOf,
    type Mark,
    patched,
    presentOf,
    valueOf,
    valueText,
} from '../src/maths/marks.ts';
import {
    isPathFile,
    type PlacedMark,
    readMarks,
    readMarkups,
    readTable,
    writeMarkups,
    writeTable,
} from '../src/maths/marks_file.ts';
import { readPath } from '../src/maths/path.ts';
import { along, cross, dot, mul, norm, normalized, sub, type Vec3 } from '../src/maths/vec.ts';
import { VolumeData } from '../src/maths/volume.ts';
import { initialState } from '../src/state/state.ts';
import { History } from '../src/state/history.ts';
import { Store } from '../src/state/store.ts';
import { between } from './random.ts';

const close = (a: number, b: number, most: number): void =>
    assert.ok(Math.abs(a - b) <= most, `${a}, expected ${b} within ${most}`);

test('lengths and angles are those of the points', () => {
    close(
        lengthOf([
            [0, 0, 0],
            [3, 4, 0],
            [3, 4, 12],
        ]),
        17,
        1e-12,
    );
    close(
        angleOf([
            [5, 0, 0],
            [0, 0, 0],
            [0, 2, 0],
        ]),
        90,
        1e-12,
    );
    close(
        angleOf([
            [1, 0, 0],
            [0, 0, 0],
            [-3, 0, 0],
        ]),
        180,
        1e-12,
    );
    // A small angle keeps its digits.
    close(
        angleOf([
            [1, 0, 0],
            [0, 0, 0],
            [1, 1e-9, 0],
        ]),
        (1e-9 * 180) / Math.PI,
        1e-18,
    );
    assert.equal(valueOf('point', [[1, 2, 3]]), undefined);
    assert.equal(
        valueText(
            valueOf('ruler', [
                [0, 0, 0],
                [0, 0, 12.345],
            ])!,
        ),
        '12.3 mm',
    );
    assert.equal(
        valueText(
            valueOf('ruler', [
                [0, 0, 0],
                [0, 0, 2.345],
            ])!,
        ),
        '2.35 mm',
    );
    assert.equal(
        valueText(
            valueOf('angle', [
                [1, 0, 0],
                [0, 0, 0],
                [0, 1, 0],
            ])!,
        ),
        '90.0°',
    );
});

test('the present position is found for the tissue of a smooth deformation', () => {
    // The inverse deformation compresses to a third in places: a plain iteration diverges there.
    const push: Vec3 = [9, -4, 2];
    const offsetAt = (p: Vec3): Vec3 => mul(Math.exp(-dot(p, p) / 200), push);
    for (let n = 0; n < 200; ++n) {
        const p: Vec3 = [between(-20, 20), between(-20, 20), between(-20, 20)];
        const rest = sub(p, offsetAt(p));
        const found = presentOf(rest, offsetAt, rest, 1);
        assert.ok(norm(sub(sub(found, offsetAt(found)), rest)) < 2e-3, `${n}: ${found}`);
    }
    // Undeformed tissue stays.
    assert.deepEqual(
        presentOf([1, 2, 3], () => [0, 0, 0], [1, 2, 3], 1),
        [1, 2, 3],
    );
});

const mark = (key: string, name: string, kind: Mark['kind'] = 'point'): Mark => ({
    key,
    kind,
    name,
    rest: [[0, 0, 0]],
    shown: true,
});

test('an undone step of marks leaves the marks that others have changed meanwhile', async () => {
    const a = mark('a', 'a');
    const store = new Store(initialState());
    const history = new History(
        store,
        async () => {},
        () => 0,
    );
    const list = (): string[] => store.state.marks.list.map(({ name }) => name);
    history.begin();
    store.set({ marks: { list: [a] } });
    history.end('point');
    // Another client adds b, and renames a.
    store.set({ marks: { list: [{ ...a, name: 'renamed' }, mark('b', 'b')] } });
    await history.undo();
    assert.deepEqual(list(), ['b']);
    await history.redo();
    assert.deepEqual(list(), ['b', 'a']);
    history.begin();
    store.set({ marks: { list: store.state.marks.list.filter(({ key }) => key !== 'b') } });
    history.end('delete mark');
    await history.undo();
    assert.deepEqual(list(), ['a', 'b']);
});

test('changes of one list apply to another', () => {
    const [a, b, c] = ['a', 'b', 'c'].map((key) => mark(key, key)) as [Mark, Mark, Mark];
    const moved = { ...a, name: 'moved' };
    assert.deepEqual(patched([a, c], [a, b], [moved, b]), [moved, c]);
    assert.deepEqual(patched([a, b, c], [a, b], [b]), [b, c]);
    assert.deepEqual(patched([b], [a], [a]), [b]);
    assert.equal(freeName('ruler', [mark('a', 'ruler 1'), mark('b', 'ruler 3')]), 'ruler 2');
});

const kMarks: readonly PlacedMark[] = [
    { kind: 'point', name: 'carina, "main"', points: [[1.5, -2, 3]], shown: true },
    { kind: 'point', name: 'spur', points: [[-0.1, 0, 1e-3]], shown: false },
    {
        kind: 'ruler',
        name: 'ruler 1',
        points: [
            [0, 0, 0],
            [3, 4, 0],
        ],
        shown: true,
    },
    {
        kind: 'angle',
        name: 'angle 1',
        points: [
            [1, 0, 0],
            [0, 0, 0],
            [0, 1, 0],
        ],
        shown: false,
    },
    {
        kind: 'curve',
        name: 'way',
        points: [
            [0, 0, 0],
            [1, 0, 0],
            [1, 1, 0],
            [1, 1, 5],
        ],
        shown: true,
    },
];

test('markups for 3D Slicer are written and read again', () => {
    const text = writeMarkups(kMarks);
    assert.deepEqual(readMarkups(text, 'a'), kMarks);
    const { markups } = JSON.parse(text);
    assert.deepEqual(
        markups.map(({ type }: { type: string }) => type),
        ['Fiducial', 'Line', 'Angle', 'Curve'],
    );
    assert.deepEqual(
        markups[0].controlPoints.map((p: { label: string }) => p.label),
        ['carina, "main"', 'spur'],
    );
    assert.deepEqual(
        markups
            .slice(1, 3)
            .map((m: { measurements: { value: number; units: string }[] }) => [
                m.measurements[0]!.value,
                m.measurements[0]!.units,
            ]),
        [
            [5, 'mm'],
            [90, 'deg'],
        ],
    );
    assert.ok(markups.every((m: { coordinateSystem: string }) => m.coordinateSystem === 'LPS'));
    assert.ok(!isPathFile(text));
    // The curve alone is a path.
    const curve = writeMarkups(kMarks.slice(4));
    assert.ok(isPathFile(curve));
    assert.equal(readPath(curve, 'a').length, 7);
});

test('a table is written and read again', () => {
    const text = writeTable(kMarks);
    assert.deepEqual(readTable(text, 'a'), kMarks);
    assert.deepEqual(readMarks('\uFEFF' + text.replaceAll('\n', '\r\n'), 'a'), kMarks);
    assert.match(text, /^ruler 1,ruler,1,5,mm,2,3,4,0$/m);
});

test('marks in RAS are converted, and invalid files are refused with a line', () => {
    const file = (markup: object): string => JSON.stringify({ markups: [markup] });
    const point = { position: [1, 2, 3] };
    const [read] = readMarkups(
        file({ type: 'Fiducial', coordinateSystem: 'RAS', controlPoints: [point] }),
        'a',
    );
    assert.deepEqual(read, { kind: 'point', name: 'point', points: [[-1, -2, 3]], shown: true });
    const head = 'name,kind,shown,value,unit,point,x_lps_mm,y_lps_mm,z_lps_mm\n';
    const bad: [string, RegExp][] = [
        ['{', /^x: expected a markups file/],
        ['{}', /^x: expected a list of markups/],
        [file({ type: 'Plane' }), /^x: markups\[0\]\.type: expected Fiducial.*found Plane/],
        [file({ type: 'Line' }), /^x: markups\[0\]: expected a list of controlPoints/],
        [file({ type: 'Line', controlPoints: [point] }), /^x: ruler: expected 2 points, found 1/],
        [
            file({ type: 'Line', controlPoints: [point, { position: [1, 'a', 2] }] }),
            /controlPoints\[1\]\.position: expected three numbers/,
        ],
        ['name,kind,x\n', /^x: expected the head name,kind,shown/],
        [`${head}a,cube,1,,,1,0,0,0\n`, /^x: row 2: kind: expected point/],
        [`${head}a,point,1,,,1,0,,0\n`, /^x: row 2: expected three coordinates/],
        [`${head}a,ruler,1,,,2,0,0,0\n`, /^x: row 2: point: expected 1/],
        [`${head}a,ruler,1,,,1,0,0,0\n`, /^x: a: expected 2 points, found 1/],
    ];
    for (const [text, message] of bad)
        assert.throws(
            () => readMarks(text, 'x'),
            (e: Error) => message.test(e.message) && !e.message.includes('\n'),
            text,
        );
});

const kGrid: Grid = {
    size: [60, 60, 60],
    spacing: [0.8, 0.8, 1],
    origin: [-24, -24, -30],
    direction: [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
    ],
};

/// Volume of a lumen whose depth below the wall is given [mm].
function volumeOf(depthAt: (x: Vec3) => number): VolumeData {
    const halves = new Uint16Array(voxelCount(kGrid));
    const [nx, ny, nz] = kGrid.size;
    for (let k = 0; k < nz; ++k)
        for (let j = 0; j < ny; ++j)
            for (let i = 0; i < nx; ++i) {
                const depth = depthAt(worldFromVoxel(kGrid, [i, j, k]));
                const hu = Math.min(Math.max(-500 - 250 * depth, -1000), 40);
                halves[i + nx * (j + ny * k)] = halfOfFloat(hu);
            }
    return new VolumeData(kGrid, halves);
}
const kSurface = { iso: -500, rising: true };
const closed = (section: CrossSection | 'open' | undefined): CrossSection => {
    assert.ok(section && section !== 'open', String(section));
    return section;
};

test('the section of a tube is its circle, straight on and oblique', () => {
    const axis = normalized([0.2, -0.3, 1]);
    const off = (x: Vec3): number => norm(cross(x, axis));
    const tube = volumeOf((x) => 7 - off(x));
    const straight = closed(crossSection(tube, [0.5, 0.3, 0.2], axis, kSurface));
    close(straight.area, Math.PI * 49, 0.01 * Math.PI * 49);
    close(straight.equivalent, 14, 0.07);
    close(straight.inscribed, 14, 0.15);
    close(straight.narrow, 14, 0.15);
    close(straight.wide, 14, 0.15);
    for (const [a] of straight.border) close(off(a), 7, 0.06);
    // 40 degrees off the axis: an ellipse.
    const side = normalized(cross(axis, [1, 0, 0]));
    const angle = (40 * Math.PI) / 180;
    const tilted = along(mul(Math.cos(angle), axis), Math.sin(angle), side);
    const ellipse = closed(crossSection(tube, [0, 0, 0], tilted, kSurface));
    close(ellipse.area, (Math.PI * 49) / Math.cos(angle), 0.015 * Math.PI * 49);
    close(ellipse.wide, 14 / Math.cos(angle), 0.2);
    close(ellipse.inscribed, 14, 0.2);
    // A vessel with contrast medium is brighter than its wall.
    const bright = new VolumeData(
        kGrid,
        tube.halves.map((h) => h ^ 0x8000),
    );
    const vessel = closed(crossSection(bright, [0, 0, 0], axis, { iso: 500, rising: false }));
    close(vessel.area, straight.area, 1e-3 * straight.area);
});

test('a section has only the lumen that is connected, and may be open or absent', () => {
    const two = volumeOf((x) =>
        Math.max(5 - Math.hypot(x[0] + 8, x[1]), 4 - Math.hypot(x[0] - 8, x[1])),
    );
    const section = closed(crossSection(two, [-8, 0, 0], [0, 0, 1], kSurface));
    close(section.area, Math.PI * 25, 0.01 * Math.PI * 25);
    assert.equal(crossSection(two, [0, 0, 0], [0, 0, 1], kSurface), undefined);
    assert.equal(crossSection(two, [-8, 0, 0], [1, 0, 0], kSurface), 'open');
    assert.equal(crossSection(two, [900, 0, 0], [0, 0, 1], kSurface), undefined);
    // A slit of two discs: the largest circle is the larger disc.
    const joined = volumeOf((x) =>
        Math.max(
            5 - Math.hypot(x[0] + 8, x[1]),
            4 - Math.hypot(x[0] - 8, x[1]),
            1.5 - Math.max(Math.abs(x[1]), Math.abs(x[0]) - 8),
        ),
    );
    const slit = closed(crossSection(joined, [8, 0, 0], [0, 0, 1], kSurface));
    close(slit.inscribed, 10, 0.5);
    close(slit.wide, 25, 0.3);
    close(slit.narrow, 10, 0.3);
});

test('sections along a path follow a tube that narrows', () => {
    const radius = (z: number): number => 8 - 0.1 * (z + 20);
    const cone = volumeOf((x) => radius(x[2]) - Math.hypot(x[0], x[1]));
    const points = Array.from({ length: 20 }, (_, n): Vec3 => [0, 0, -19 + 2 * n]);
    const sections = [...sectionsAlong(cone, points, kSurface)].map(closed);
    sections.forEach((s, n) => close(s.equivalent, 2 * radius(points[n]![2]), 0.12));
});
