// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Marks of catheters and instruments in the sections: outlined, at least three pixels wide, with a
// dot where they cross the slice.

import { dot, sub, type Vec3 } from '../maths/vec.ts';
import { hasVessel, surfaceOf } from '../state/state.ts';
import { scaleOf } from '../state/units.ts';
import type { Session } from '../tools/session.ts';
import { instrumentOf, lumenOf, type ToolBall } from '../views/instruments.ts';
import { pixelOfWorld, type SectionPlane } from '../views/section_geometry.ts';
import { chainParts, crossings } from './chain_marks.ts';
import { svg } from './dom.ts';
import { headOutlines } from './head_marks.ts';

const kMinPixels = 3;
const kRim = 2.5; // both sides together [pixels]
const kFarAway: Vec3 = [1e9, 1e9, 1e9]; // an eye outside of all shafts

export function catheterMarks({ vessel, store }: Session, plane: SectionPlane): SVGElement[] {
    if (!vessel || !hasVessel(store.state)) return [];
    const { catheter, radius } = vessel;
    return [...chainMarks('catheter', catheter, radius, plane), ...dots(catheter, radius, plane)];
}

export function instrumentMarks(
    { volume, stage, store }: Session,
    plane: SectionPlane,
): SVGElement[] {
    if (!volume || !stage.balls.length) return [];
    const { camera } = store.state.view;
    const scale = scaleOf(store.state.scan.volume);
    const lumen = lumenOf(volume, camera, surfaceOf(store.state), scale);
    return stage.balls.flatMap((ball) => {
        const tool = instrumentOf(ball, camera, lumen, kFarAway);
        const { base, wrist, thickness } = tool;
        const whose = ball.own ? ' own' : '';
        const outlines = headOutlines(ball, tool, plane);
        const shape = (kind: string, width: number): SVGElement[] =>
            outlines.map(({ points, near, open }) =>
                svg(open ? 'polyline' : 'polygon', {
                    class: near ? `${kind} near` : kind,
                    points: points.join(' '),
                    'stroke-width': width,
                }),
            );
        return [
            ...reachMark(ball, plane),
            ...chainMarks(`shaft${whose}`, [base, wrist], thickness, plane),
            ...shape('rim', kMinPixels + kRim),
            ...shape(`head${whose}`, kMinPixels),
            ...dots([base, wrist, ball.centre], thickness, plane),
        ];
    });
}

/// Section of the sphere that a grasper holds or a scoop takes out.
function reachMark({ kind, centre, radius }: ToolBall, plane: SectionPlane): SVGElement[] {
    const off = dot(sub(centre, plane.centre), plane.axes.normal);
    if ((kind !== 'grasper' && kind !== 'scoop') || Math.abs(off) >= radius) return [];
    const [cx, cy] = pixelOfWorld(plane, centre);
    const r = Math.sqrt(radius * radius - off * off) / plane.mmPerPixel;
    return [svg('circle', { class: 'reach', cx, cy, r })];
}

function dots(points: readonly Vec3[], radius: number, plane: SectionPlane): SVGElement[] {
    const r = Math.max(radius / plane.mmPerPixel, kMinPixels);
    return crossings(points, plane).map(([cx, cy]) =>
        svg('circle', { class: 'pierced', cx, cy, r }),
    );
}

function chainMarks(
    kind: string,
    points: readonly Vec3[],
    radius: number,
    plane: SectionPlane,
): SVGElement[] {
    const wide = (2 * radius) / plane.mmPerPixel;
    const parts = chainParts(points, plane, radius);
    const lines = (name: string, more: number): SVGElement[] =>
        parts.map(({ points: spots, near }) =>
            svg('polyline', {
                class: near ? `${name} near` : name,
                points: spots.join(' '),
                'stroke-width': (near ? Math.max(wide, kMinPixels) : kMinPixels) + more,
            }),
        );
    return [...lines('rim', kRim), ...lines(kind, 0)];
}
