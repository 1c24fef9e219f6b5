// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Marks: points with names, rulers, angles and curves. Their points belong to the tissue: stored is
// the position at rest, and shown is the position of the same tissue now. So a mark moves with the
// tissue, and a ruler has the present length.
//
//   position at rest X = p − u(p)        u: offset of the rest field at the present position p
//   present position p: the root of p − u(p) − X

import { fixed } from './steps.ts';
import { add, dot, norm, sub, type Vec3 } from './vec.ts';

export const kMarkKinds = ['point', 'ruler', 'angle', 'curve'] as const;
export type MarkKind = (typeof kMarkKinds)[number];

export interface Mark {
    readonly key: string; ///< identifies the mark in the session
    readonly kind: MarkKind;
    readonly name: string;
    readonly rest: readonly Vec3[]; ///< at rest [mm, LPS]; an angle's vertex is the second
    readonly shown: boolean;
}

/// Number of points of a mark that is set by clicks.
export const kPointsOf: Record<Exclude<MarkKind, 'curve'>, number> = {
    point: 1,
    ruler: 2,
    angle: 3,
};

/// Offset of the tissue that is at a position now: position at rest = position − offset [mm, LPS].
export type OffsetAt = (place: Vec3) => Vec3;

export const lengthOf = (points: readonly Vec3[]): number =>
    points.reduce((sum, p, i) => (i > 0 ? sum + norm(sub(p, points[i - 1]!)) : 0), 0);

/// Angle at the second of three points [degrees].
export function angleOf([a, b, c]: readonly Vec3[]): number {
    const u = sub(a!, b!);
    const v = sub(c!, b!);
    // Kahan's formula: exact for small and for flat angles as well.
    const [p, q] = [norm(u), norm(v)];
    const x = u.map((n, i) => n * q - v[i]! * p) as unknown as Vec3;
    const y = u.map((n, i) => n * q + v[i]! * p) as unknown as Vec3;
    return (2 * Math.atan2(norm(x), norm(y)) * 180) / Math.PI;
}

export interface Value {
    readonly number: number;
    readonly unit: 'mm' | '°';
}

/// Measured value of a mark; undefined for a point.
export function valueOf(kind: MarkKind, points: readonly Vec3[]): Value | undefined {
    if (kind === 'point') return undefined;
    if (kind === 'angle') return { number: angleOf(points), unit: '°' };
    return { number: lengthOf(points), unit: 'mm' };
}

/// Text of a value. @param scale  of lengths: 1 in a body
export const valueText = ({ number, unit }: Value, scale = 1): string =>
    unit === '°'
        ? `${number.toFixed(1)}°`
        : `${fixed(number, (number < 10 * scale ? 0.01 : 0.1) * scale)} mm`;

const kSteps = 40;
const kClose = 1e-3; // residual [mm]

/// Present position of the tissue at a position at rest. Newton's method with differences, from
/// the last known position; steps that don't reduce the residual are halved.
/// @param guess  last position, or that at rest
/// @param h  distance for differences, about a voxel [mm]
export function presentOf(rest: Vec3, offsetAt: OffsetAt, guess: Vec3, h: number): Vec3 {
    const residual = (p: Vec3): Vec3 => sub(sub(p, offsetAt(p)), rest);
    let place = guess;
    let r = residual(place);
    for (let i = 0; i < kSteps && norm(r) > kClose; ++i) {
        const step = newtonStep(residual, place, r, h) ?? sub([0, 0, 0], r);
        let share = 1;
        let next = add(place, step);
        let nextR = residual(next);
        while (norm(nextR) >= norm(r) && share > 0.05) {
            share /= 2;
            next = add(place, step.map((s) => share * s) as unknown as Vec3);
            nextR = residual(next);
        }
        if (norm(nextR) >= norm(r)) {
            // A kink of the field: a plain step of the fixed-point iteration.
            next = sub(place, r);
            nextR = residual(next);
            if (norm(nextR) >= norm(r)) break;
        }
        place = next;
        r = nextR;
    }
    return place;
}

function newtonStep(
    residual: (p: Vec3) => Vec3,
    place: Vec3,
    r: Vec3,
    h: number,
): Vec3 | undefined {
    const columns = [0, 1, 2].map((a) => {
        const ahead = place.map((x, b) => (a === b ? x + h : x)) as unknown as Vec3;
        return sub(residual(ahead), r).map((d) => d / h) as unknown as Vec3;
    }) as [Vec3, Vec3, Vec3];
    const [a, b, c] = columns;
    const cross = (u: Vec3, v: Vec3): Vec3 => [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    const det = dot(a, cross(b, c));
    if (Math.abs(det) < 1e-3) return undefined;
    // Cramer's rule.
    return [-dot(r, cross(b, c)) / det, -dot(r, cross(c, a)) / det, -dot(r, cross(a, b)) / det];
}

/// Applies the changes between two lists to a third, which may have got other changes since.
export function patched(
    now: readonly Mark[],
    from: readonly Mark[],
    to: readonly Mark[],
): readonly Mark[] {
    if (from === to) return now;
    const before = new Map(from.map((mark) => [mark.key, mark]));
    const after = new Map(to.map((mark) => [mark.key, mark]));
    const kept = now
        .filter(({ key }) => after.has(key) || !before.has(key))
        .map((mark) =>
            before.get(mark.key) === after.get(mark.key) ? mark : (after.get(mark.key) ?? mark),
        );
    const present = new Set(kept.map(({ key }) => key));
    const back = to.filter(({ key }) => !before.has(key) && !present.has(key));
    return [...kept, ...back];
}

/// Name that no mark has yet: the word and the next number.
export function freeName(word: string, marks: readonly Mark[]): string {
    const taken = new Set(marks.map(({ name }) => name));
    let n = 1;
    while (taken.has(`${word} ${n}`)) ++n;
    return `${word} ${n}`;
}
