// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Outlines of instruments' heads in the sections, against the bodies' equations, with random poses
// and slices: points of an outline lie on the surface, and each extreme point of the body, found by
// sampling it, is reached.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { add, along, cross, dot, mul, norm, normalized, sub, type Vec3 } from '../src/maths/vec.ts';
import { type HeadOutline, headOutlines } from '../src/panels/head_marks.ts';
import type { Instrument, ToolKind } from '../src/views/instruments.ts';
import {
    kSectionAxes,
    pixelOfWorld,
    type SectionPlane,
    worldOfPixel,
} from '../src/views/section_geometry.ts';
import { between } from './random.ts';

const kRounds = 60;

interface Pose {
    readonly centre: Vec3;
    readonly radius: number;
    readonly tool: Instrument;
    readonly v: Vec3; ///< third axis of the head
}

const unit = (): Vec3 =>
    normalized([between(-1, 1), between(-1, 1), between(-1, 1)].map((x) => x + 1e-3) as never);

function randomPose(kind: ToolKind): Pose {
    const centre: Vec3 = [between(-5, 5), between(-5, 5), between(-5, 5)];
    const radius = between(2, 5);
    const axis = unit();
    const side = normalized(cross(axis, unit()));
    const angle = kind === 'blade' ? (between(0, 1) < 0.5 ? -1 : 1) : between(-0.03, 0.5);
    const wrist = along(centre, -between(0.8, 2) * radius, axis);
    const base = along(wrist, -20, axis);
    const tool = { base, wrist, thickness: 0.5, axis, side, angle };
    return { centre, radius, tool, v: cross(axis, side) };
}

function randomPlane(near: Vec3, reach: number): SectionPlane {
    const axes = Object.values(kSectionAxes)[Math.floor(between(0, 2.999))]!;
    const off = between(-reach, reach);
    return {
        axes,
        centre: along(near, off, axes.normal),
        mmPerPixel: between(0.05, 0.5),
        width: 400,
        height: 300,
    };
}

/// Value of a body at a point, in units of length: 0 on its surface, negative inside.
type Body = (p: Vec3) => number;

function bodiesOf(kind: ToolKind, { centre, radius: r, tool, v }: Pose): Body[] {
    const { wrist, axis: h, side: e, angle } = tool;
    const ball = (c: Vec3, radius: number): Body => (p) => norm(sub(p, c)) - radius;
    if (kind === 'ball') return [ball(centre, r)];
    if (kind === 'grasper') {
        const jaw = (sign: number): Body => {
            const a = add(mul(Math.cos(angle), h), mul(sign * Math.sin(angle), v));
            const b = add(mul(sign * Math.cos(angle), v), mul(-Math.sin(angle), h));
            const c = add(wrist, add(mul(0.85 * r, a), mul(0.14 * r, b)));
            return (p) => {
                const q = sub(p, c);
                const s = [dot(q, a) / 0.88, dot(q, b) / 0.16, dot(q, e) / 0.28];
                return 0.16 * (Math.hypot(...s) - r);
            };
        };
        return [jaw(-1), jaw(1), ball(wrist, 0.28 * r)];
    }
    if (kind === 'blade')
        return [
            (p) => {
                const q = sub(p, centre);
                const [x, y, z] = [dot(q, h), angle * dot(q, v), dot(q, e)];
                const slant = (0.5 * (x - 0.15 * r) - (y - 0.3 * r)) / Math.hypot(0.5, 1);
                const [back, belly, butt] = [y - 0.3 * r, -y - 0.5 * r, -x - 2.2 * r];
                return Math.max(back, belly, butt, Math.abs(z) - 0.07 * r, slant);
            },
        ];
    const mouth = normalized(add(mul(0.3, h), e));
    return [
        (p) => {
            const q = sub(p, centre);
            const beyond = dot(q, mouth) - 0.1 * 0.85 * r;
            return Math.max(Math.abs(norm(q) - 0.85 * r), beyond);
        },
    ];
}

/// Extents of outlines along a direction of the picture [pixels].
function extent(outlines: readonly HeadOutline[], turn: number): number {
    const [x, y] = [Math.cos(turn), Math.sin(turn)];
    return Math.max(
        ...outlines.flatMap(({ points }) => points.map(([u, w]) => u * x + w * y)),
    );
}

for (const kind of ['ball', 'grasper', 'blade', 'scoop'] as const)
    test(`outlines of the ${kind} are those of its body`, () => {
        let cuts = 0;
        for (let round = 0; round < kRounds; ++round) {
            const pose = randomPose(kind);
            const { centre, radius, tool } = pose;
            const plane = randomPlane(centre, 1.2 * radius);
            const ball = { centre, radius, own: true, kind };
            const outlines = headOutlines(ball, tool, plane);
            const bodies = bodiesOf(kind, pose);
            for (const { points } of outlines.filter(({ near }) => near)) {
                ++cuts;
                for (const [x, y] of points) {
                    const p = worldOfPixel(plane, x, y);
                    const off = Math.min(...bodies.map((body) => Math.abs(body(p))));
                    assert.ok(off < 1e-6 * radius, `${off} mm off the surface`);
                }
            }
            // Points of the bodies: in the slice, and anywhere.
            const { right, up, normal } = plane.axes;
            const reach = 4 * radius;
            const inside = (p: Vec3): boolean => bodies.some((body) => body(p) < 1e-9);
            const spoon = 0.85 * radius;
            const turns = [0, 0.7, 1.6, 2.9, 3.5, 4.4, 5.6];
            for (const near of [true, false]) {
                const seen = outlines.filter((outline) => outline.near === near);
                const farthest = turns.map(() => -Infinity);
                const on = dot(sub(plane.centre, centre), normal);
                for (let n = 0; n < 40_000; ++n) {
                    let [a, b] = [between(-reach, reach), between(-reach, reach)];
                    let depth = near ? on : between(-reach, reach);
                    if (kind === 'scoop') {
                        // A sheet: points of its sphere.
                        depth = near ? on : between(-spoon, spoon);
                        const wide = Math.sqrt(spoon * spoon - depth * depth);
                        const turn = between(0, 2 * Math.PI);
                        [a, b] = [wide * Math.cos(turn), wide * Math.sin(turn)];
                    }
                    const flat = add(mul(a, right), mul(b, up));
                    const p = add(along(centre, depth, normal), flat);
                    if (!inside(p)) continue;
                    const [x, y] = pixelOfWorld(plane, p);
                    turns.forEach((turn, i) => {
                        const far = x * Math.cos(turn) + y * Math.sin(turn);
                        farthest[i] = Math.max(farthest[i]!, far);
                    });
                }
                if (farthest[0] === -Infinity) continue;
                assert.ok(seen.length > 0, 'a body in the slice has an outline');
                turns.forEach((turn, i) => {
                    const missing = (farthest[i]! - extent(seen, turn)) * plane.mmPerPixel;
                    assert.ok(missing < 0.03 * radius, `${missing} mm are missing`);
                });
            }
        }
        assert.ok(cuts > kRounds / 6, `${cuts} sections`);
    });
