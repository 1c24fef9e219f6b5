// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Marks of a polyline in a section, for catheters and shafts: its projection faint, the parts near
// the section strong.

import { along, dot, sub, type Vec3 } from '../maths/vec.ts';
import { pixelOfWorld, type SectionPlane } from '../views/section_geometry.ts';

export interface ChainMark {
    readonly points: readonly (readonly [number, number])[]; ///< [pixels]
    readonly near: boolean; ///< lies in the section
}

/// Parts of a polyline to draw. @param reach  largest distance of a point in the section [mm]
export function chainParts(
    points: readonly Vec3[],
    plane: SectionPlane,
    reach: number,
): ChainMark[] {
    if (points.length < 2) return [];
    const spots = points.map((p) => pixelOfWorld(plane, p));
    const off = points.map((p) => dot(sub(p, plane.centre), plane.axes.normal));
    const marks: ChainMark[] = [{ points: spots, near: false }];
    for (let i = 0; i + 1 < points.length; ++i) {
        // Part of the segment within reach: the distance is linear along it.
        const [a, b] = [off[i]!, off[i + 1]!];
        const bounds = [-reach, reach].map((r) => (a === b ? Infinity : (r - a) / (b - a)));
        const inside = Math.abs(a) <= reach && a === b;
        const from = inside ? 0 : Math.max(0, Math.min(...bounds));
        const to = inside ? 1 : Math.min(1, Math.max(...bounds));
        if (!(to > from)) continue;
        const at = (t: number): [number, number] => [
            spots[i]![0] + t * (spots[i + 1]![0] - spots[i]![0]),
            spots[i]![1] + t * (spots[i + 1]![1] - spots[i]![1]),
        ];
        marks.push({ points: [at(from), at(to)], near: true });
    }
    return marks;
}

/// Points where a polyline crosses the section [pixels].
export function crossings(
    points: readonly Vec3[],
    plane: SectionPlane,
): (readonly [number, number])[] {
    const off = points.map((p) => dot(sub(p, plane.centre), plane.axes.normal));
    const spots: (readonly [number, number])[] = [];
    for (let i = 0; i + 1 < points.length; ++i) {
        const [a, b] = [off[i]!, off[i + 1]!];
        if (a > 0 === b > 0) continue;
        const share = a / (a - b);
        spots.push(pixelOfWorld(plane, along(points[i]!, share, sub(points[i + 1]!, points[i]!))));
    }
    return spots;
}
