// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Outlines of an instrument's head in a section: the bodies of shaders/instrument.glsl, cut by the
// plane of the section, and projected on it. Ellipsoids are maps of the unit sphere, whose sections
// and silhouettes are circles; a blade is a prism; a spoon is a part of a sphere, so its section is
// an arc.

import { add, along, cross, dot, mul, norm, normalized, sub, type Vec3 } from '../maths/vec.ts';
import type { Instrument, ToolBall } from '../views/instruments.ts';
import { pixelOfWorld, type SectionPlane } from '../views/section_geometry.ts';

type Spot = readonly [number, number]; // [pixels]

export interface HeadOutline {
    readonly points: readonly Spot[];
    readonly near: boolean; ///< cut by the section; else projected on it
    readonly open: boolean; ///< an arc
}

const kParts = 48; // points of a circle
// Shapes of the shader, in radii of the head's sphere.
const kHinge = 0.28;
const kJaw: Vec3 = [0.88, 0.16, 0.28];
const kJawAlong = 0.85;
const kJawAcross = 0.14;
const kBlade: readonly (readonly [number, number])[] = [
    [-2.2, -0.5],
    [-1.45, -0.5],
    [0.15, 0.3],
    [-2.2, 0.3],
];
const kBladeHalf = 0.07; // thickness
const kSpoon = 0.85;
const kMouth = 0.1; // height of the spoon's rim over its centre, in radii of the spoon

/// Ellipsoid; axes are unit vectors, perpendicular to each other.
interface Ellipsoid {
    readonly centre: Vec3;
    readonly axes: readonly [Vec3, Vec3, Vec3];
    readonly lengths: Vec3;
}

/// Outlines of a head in a section, by bodies; endoscopes have none beside their shaft.
export function headOutlines(ball: ToolBall, tool: Instrument, plane: SectionPlane): HeadOutline[] {
    const { centre, radius: r, kind } = ball;
    const { wrist, axis: h, side: e, angle } = tool;
    const v = cross(h, e);
    const sphere = (c: Vec3, radius: number): Ellipsoid => ({
        centre: c,
        axes: [h, v, e],
        lengths: [radius, radius, radius],
    });
    switch (kind) {
        case 'ball':
            return ellipsoidOutlines(sphere(centre, r), plane);
        case 'grasper': {
            const jaws = [-1, 1].map((sign): Ellipsoid => {
                const out = mul(sign, v);
                const length = add(mul(Math.cos(angle), h), mul(Math.sin(angle), out));
                const width = sub(mul(Math.cos(angle), out), mul(Math.sin(angle), h));
                return {
                    centre: along(along(wrist, kJawAlong * r, length), kJawAcross * r, width),
                    axes: [length, width, e],
                    lengths: mul(r, kJaw),
                };
            });
            const bodies = [...jaws, sphere(wrist, kHinge * r)];
            return bodies.flatMap((body) => ellipsoidOutlines(body, plane));
        }
        case 'blade':
            return bladeOutlines(centre, r, h, mul(angle, v), e, plane);
        case 'scoop':
            return spoonOutlines(
                sphere(centre, kSpoon * r),
                normalized(add(mul(0.3, h), e)),
                plane,
            );
        case 'scope':
            return [];
    }
}

/// Points of a circle on the unit sphere, mapped to the ellipsoid.
/// @param normal  of the circle's plane, in the ellipsoid's axes
/// @param height  of that plane over the centre, in [-1, 1]
function circleOn({ centre, axes, lengths }: Ellipsoid, normal: Vec3, height: number): Vec3[] {
    const w = normalized(normal);
    const u = normalized(cross(w, Math.abs(w[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0]));
    const v = cross(w, u);
    const wide = Math.sqrt(Math.max(1 - height * height, 0));
    return Array.from({ length: kParts }, (_, i) => {
        const turn = (2 * Math.PI * i) / kParts;
        const q = add(
            mul(height, w),
            add(mul(wide * Math.cos(turn), u), mul(wide * Math.sin(turn), v)),
        );
        return axes.reduce((p, axis, a) => along(p, q[a]! * lengths[a]!, axis), centre);
    });
}

/// Section of an ellipsoid; undefined: the plane misses it.
function sectionOf(body: Ellipsoid, plane: SectionPlane): Vec3[] | undefined {
    const n = plane.axes.normal;
    const m = body.axes.map((axis, a) => body.lengths[a]! * dot(axis, n)) as never as Vec3;
    const height = dot(sub(plane.centre, body.centre), n) / norm(m);
    return Math.abs(height) < 1 ? circleOn(body, m, height) : undefined;
}

function silhouetteOf(body: Ellipsoid, plane: SectionPlane): Vec3[] {
    const n = plane.axes.normal;
    const m = body.axes.map((axis, a) => dot(axis, n) / body.lengths[a]!) as never as Vec3;
    return circleOn(body, m, 0);
}

function ellipsoidOutlines(body: Ellipsoid, plane: SectionPlane): HeadOutline[] {
    const cut = sectionOf(body, plane);
    const outlines = [closed(silhouetteOf(body, plane), plane, false)];
    return cut ? [...outlines, closed(cut, plane, true)] : outlines;
}

const closed = (points: readonly Vec3[], plane: SectionPlane, near: boolean): HeadOutline => ({
    points: points.map((p) => pixelOfWorld(plane, p)),
    near,
    open: false,
});

function bladeOutlines(
    centre: Vec3,
    r: number,
    h: Vec3,
    v: Vec3,
    e: Vec3,
    plane: SectionPlane,
): HeadOutline[] {
    const faces = [-kBladeHalf, kBladeHalf].map((z) =>
        kBlade.map(([x, y]) => along(along(along(centre, x * r, h), y * r, v), z * r, e)),
    ) as [Vec3[], Vec3[]];
    const edges = kBlade.flatMap((_, i) => [
        [faces[0][i]!, faces[1][i]!],
        ...faces.map((face) => [face[i]!, face[(i + 1) % face.length]!]),
    ]) as [Vec3, Vec3][];
    const { normal } = plane.axes;
    const off = (p: Vec3): number => dot(sub(p, plane.centre), normal);
    const cut = edges
        .filter(([a, b]) => off(a) > 0 !== off(b) > 0)
        .map(([a, b]) => along(a, off(a) / (off(a) - off(b)), sub(b, a)));
    const outline = (points: readonly Vec3[], near: boolean): HeadOutline => ({
        points: hull(points.map((p) => pixelOfWorld(plane, p))),
        near,
        open: false,
    });
    const outlines = [outline(faces.flat(), false)];
    return cut.length > 2 ? [...outlines, outline(cut, true)] : outlines;
}

/// @param mouth  unit, from the spoon's centre to the middle of its opening
function spoonOutlines(body: Ellipsoid, mouth: Vec3, plane: SectionPlane): HeadOutline[] {
    const rim = kMouth * body.lengths[0];
    const inMetal = (p: Vec3): boolean => dot(sub(p, body.centre), mouth) <= rim;
    const opening = body.axes.map((axis) => dot(axis, mouth)) as never as Vec3;
    const seen = [
        ...silhouetteOf(body, plane).filter(inMetal),
        ...circleOn(body, opening, kMouth),
    ];
    const outlines: HeadOutline[] = [
        { points: hull(seen.map((p) => pixelOfWorld(plane, p))), near: false, open: false },
    ];
    const arc = spoonArc(body, mouth, plane, inMetal);
    if (arc.length > 1)
        outlines.push({
            points: arc.map((p) => pixelOfWorld(plane, p)),
            near: true,
            open: arc.length !== kParts,
        });
    return outlines;
}

/// Section of a spoon: the circle of its sphere, up to the rim.
function spoonArc(
    body: Ellipsoid,
    mouth: Vec3,
    plane: SectionPlane,
    inMetal: (p: Vec3) => boolean,
): Vec3[] {
    const circle = sectionOf(body, plane) ?? [];
    const gap = circle.findIndex((p) => !inMetal(p));
    if (gap < 0) return circle;
    // Starts at the opening, so that the arc is in one piece.
    const arc = [...circle.slice(gap), ...circle.slice(0, gap)].filter(inMetal);
    if (!arc.length) return [];
    // Ends: where rim, sphere and plane meet.
    const radius = body.lengths[0];
    const { normal } = plane.axes;
    const [a, b] = [dot(sub(plane.centre, body.centre), normal), kMouth * radius];
    const c = dot(normal, mouth);
    const [alpha, beta] = [(a - b * c) / (1 - c * c), (b - a * c) / (1 - c * c)];
    const middle = along(along(body.centre, alpha, normal), beta, mouth);
    const side = normalized(cross(normal, mouth));
    const reach = Math.sqrt(Math.max(radius * radius - alpha * a - beta * b, 0));
    const ends = [reach, -reach].map((way) => along(middle, way, side)) as [Vec3, Vec3];
    const first = norm(sub(ends[0], arc[0]!)) < norm(sub(ends[1], arc[0]!)) ? 0 : 1;
    return [ends[first]!, ...arc, ends[1 - first]!];
}

/// Convex hull, by Andrew's monotone chains.
function hull(spots: readonly Spot[]): Spot[] {
    const sorted = [...spots].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const chainOf = (row: readonly Spot[]): Spot[] => {
        const chain: Spot[] = [];
        for (const c of row) {
            for (; chain.length > 1; chain.pop()) {
                const [a, b] = chain.slice(-2) as [Spot, Spot];
                if ((b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])) break;
            }
            chain.push(c);
        }
        return chain.slice(0, -1);
    };
    return [...chainOf(sorted), ...chainOf(sorted.reverse())];
}
