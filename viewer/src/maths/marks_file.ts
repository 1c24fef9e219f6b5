// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files of marks: markups of 3D Slicer (.mrk.json), and tables (.csv). Both hold present positions
// in LPS [mm], so that a file agrees with the saved volume. Points are written as one list of
// Slicer, in which each has its label; other marks are markups of their own.

import { type Mark, type MarkKind, type Value, valueOf } from './marks.ts';
import type { Vec3 } from './vec.ts';

/// A mark at its present position.
export interface PlacedMark {
    readonly kind: MarkKind;
    readonly name: string;
    readonly points: readonly Vec3[];
    readonly shown: boolean;
}

export const kMaxMarks = 256;
export const kMaxMarkPoints = 500;
export const kMaxNameLength = 80;

const kSchema =
    'https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/' +
    'Resources/Schema/markups-schema-v1.0.3.json#';
const kTypes: Record<MarkKind, string> = {
    point: 'Fiducial',
    ruler: 'Line',
    angle: 'Angle',
    curve: 'Curve',
};
/// Fewest and most points of each kind.
const kCounts: Record<MarkKind, readonly [number, number]> = {
    point: [1, 1],
    ruler: [2, 2],
    angle: [3, 3],
    curve: [2, kMaxMarkPoints],
};

const controlPoint = (label: string, position: Vec3, n: number, shown: boolean): object => ({
    id: String(n),
    label,
    description: '',
    associatedNodeID: '',
    position,
    selected: true,
    locked: false,
    visibility: shown,
    positionStatus: 'defined',
});

const measurement = ({ number, unit }: Value): object => ({
    name: unit === '°' ? 'angle' : 'length',
    enabled: true,
    value: number,
    units: unit === '°' ? 'deg' : 'mm',
});

/// Writes markups for 3D Slicer.
export function writeMarkups(marks: readonly PlacedMark[]): string {
    const base = { coordinateSystem: 'LPS', coordinateUnits: 'mm', locked: false };
    const points = marks.filter(({ kind }) => kind === 'point');
    const markups: object[] = [];
    if (points.length)
        markups.push({
            type: kTypes.point,
            ...base,
            name: 'points',
            labelFormat: '%N-%d',
            controlPoints: points.map((mark, n) =>
                controlPoint(mark.name, mark.points[0]!, n + 1, mark.shown),
            ),
        });
    for (const { kind, name, points: places, shown } of marks) {
        if (kind === 'point') continue;
        const value = valueOf(kind, places);
        markups.push({
            type: kTypes[kind],
            ...base,
            name,
            labelFormat: '%N-%d',
            controlPoints: places.map((p, n) => controlPoint(`${name}-${n + 1}`, p, n + 1, true)),
            measurements: value ? [measurement(value)] : [],
            display: { visibility: shown },
        });
    }
    return JSON.stringify({ '@schema': kSchema, markups }, null, 1) + '\n';
}

interface Markup {
    type?: unknown;
    name?: unknown;
    coordinateSystem?: string | number;
    controlPoints?: { label?: unknown; position?: unknown; visibility?: unknown }[];
    display?: { visibility?: unknown };
}

/// Tests whether a markups file is a single curve, which the page takes as a path.
export function isPathFile(text: string): boolean {
    try {
        const { markups } = JSON.parse(text) as { markups?: Markup[] };
        if (!Array.isArray(markups) || markups.length !== 1) return !Array.isArray(markups);
        const type = markups[0]?.type ?? 'Curve';
        return type === 'Curve' || type === 'ClosedCurve';
    } catch {
        return true; // the reader of paths says why it is none
    }
}

/// Reads markups of 3D Slicer. @throws an Error that names the wrong field
export function readMarkups(text: string, name: string): PlacedMark[] {
    let file: { markups?: Markup[] };
    try {
        file = JSON.parse(text);
    } catch {
        throw new Error(`${name}: expected a markups file (.mrk.json), found no JSON`);
    }
    if (!Array.isArray(file?.markups)) throw new Error(`${name}: expected a list of markups`);
    return checked(
        file.markups.flatMap((markup, n) => marksOf(markup, `${name}: markups[${n}]`)),
        name,
    );
}

function marksOf(markup: Markup, where: string): PlacedMark[] {
    const kind = (Object.keys(kTypes) as MarkKind[]).find((k) => kTypes[k] === markup?.type);
    if (!kind) {
        const types = Object.values(kTypes).join(', ');
        throw new Error(`${where}.type: expected ${types}, found ${String(markup?.type)}`);
    }
    if (!Array.isArray(markup.controlPoints))
        throw new Error(`${where}: expected a list of controlPoints`);
    // Old files of Slicer have 0 for RAS and 1 for LPS.
    const system = markup.coordinateSystem ?? 'LPS';
    const ras = system === 'RAS' || system === 0 || system === '0';
    const places = markup.controlPoints.map(({ position }, i): Vec3 => {
        const p = position as number[];
        if (!Array.isArray(p) || p.length !== 3 || !p.every(Number.isFinite))
            throw new Error(`${where}.controlPoints[${i}].position: expected three numbers`);
        return ras ? [-p[0]!, -p[1]!, p[2]!] : [p[0]!, p[1]!, p[2]!];
    });
    const own = typeof markup.name === 'string' ? markup.name : '';
    const shown = markup.display?.visibility !== false;
    if (kind !== 'point') return [{ kind, name: own, points: places, shown }];
    return places.map((place, i) => {
        const { label, visibility } = markup.controlPoints![i]!;
        const text = typeof label === 'string' ? label : '';
        return { kind, name: text, points: [place], shown: shown && visibility !== false };
    });
}

/// Checks numbers of points, and shortens names.
function checked(marks: readonly PlacedMark[], file: string): PlacedMark[] {
    if (marks.length > kMaxMarks)
        throw new Error(`${file}: expected up to ${kMaxMarks} marks, found ${marks.length}`);
    return marks.map((mark) => {
        const [least, most] = kCounts[mark.kind];
        const count = mark.points.length;
        if (count < least || count > most) {
            const expected = least === most ? `${least}` : `${least}…${most}`;
            throw new Error(
                `${file}: ${mark.name || mark.kind}: expected ${expected} points, found ${count}`,
            );
        }
        return { ...mark, name: (mark.name || mark.kind).slice(0, kMaxNameLength) };
    });
}

const kHead = 'name,kind,shown,value,unit,point,x_lps_mm,y_lps_mm,z_lps_mm';

const quoted = (text: string): string =>
    /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;

/// Writes a table: a row for each point.
export function writeTable(marks: readonly PlacedMark[]): string {
    const rows = marks.flatMap(({ kind, name, points, shown }) => {
        const value = valueOf(kind, points);
        const text = value ? [String(Number(value.number.toFixed(4))), value.unit] : ['', ''];
        return points.map((p, n) =>
            [quoted(name), kind, shown ? 1 : 0, ...text, n + 1, ...p].join(','),
        );
    });
    return [kHead, ...rows].join('\n') + '\n';
}

/// Tests whether a table is one of marks.
export const isMarkTable = (text: string): boolean => /^\uFEFF?name,kind,/.test(text);

/// Reads a table of marks. @throws an Error that names the wrong line
export function readTable(text: string, name: string): PlacedMark[] {
    const [head, ...rows] = rowsOf(text.replace(/^\uFEFF/, ''));
    if (head?.join(',') !== kHead)
        throw new Error(`${name}: expected the head ${kHead}, found ${head?.join(',') ?? 'none'}`);
    const marks: { kind: MarkKind; name: string; points: Vec3[]; shown: boolean }[] = [];
    rows.forEach((row, n) => {
        const where = `${name}: row ${n + 2}`;
        const [own, kind, shown, , , point, ...place] = row;
        if (!(kind! in kTypes))
            throw new Error(`${where}: kind: expected point, ruler, angle or curve, found ${kind}`);
        const p = place.map(Number);
        if (place.length !== 3 || !p.every(Number.isFinite) || place.some((x) => !x.trim()))
            throw new Error(`${where}: expected three coordinates, found ${place.join(',')}`);
        const last = marks[marks.length - 1];
        if (Number(point) === 1)
            marks.push({
                kind: kind as MarkKind,
                name: own!,
                points: [p as unknown as Vec3],
                shown: shown !== '0',
            });
        else if (last && Number(point) === last.points.length + 1)
            last.points.push(p as unknown as Vec3);
        else throw new Error(`${where}: point: expected ${(last?.points.length ?? 0) + 1} or 1`);
    });
    return checked(marks, name);
}

/// Cells of a table, with quotes as in RFC 4180.
function rowsOf(text: string): string[][] {
    const rows: string[][] = [];
    let row: string[] = [];
    const cell = /(?:"((?:[^"]|"")*)"|([^",\r\n]*))(,|\r?\n|$)/gy;
    for (let found = cell.exec(text); found; found = cell.exec(text)) {
        row.push(found[1] === undefined ? found[2]! : found[1].replaceAll('""', '"'));
        if (found[3] !== ',') {
            if (row.length > 1 || row[0]) rows.push(row);
            row = [];
        }
        if (cell.lastIndex >= text.length) break;
    }
    return rows;
}

/// Marks of a file, by its contents. @throws an Error with the reason why it has none
export const readMarks = (text: string, name: string): PlacedMark[] =>
    isMarkTable(text) ? readTable(text, name) : readMarkups(text, name);

export const placedOf = ({ kind, name, shown }: Mark, points: readonly Vec3[]): PlacedMark => ({
    kind,
    name,
    points,
    shown,
});
