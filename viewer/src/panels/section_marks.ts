// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Marks of catheters and shafts in the sections: outlined, at least three pixels wide, with a dot
// where they cross the slice.

import type { Vec3 } from '../maths/vec.ts';
import { hasVessel, surfaceOf } from '../state/state.ts';
import type { Session } from '../tools/session.ts';
import { instrumentOf, lumenOf } from '../views/instruments.ts';
import type { SectionPlane } from '../views/section_geometry.ts';
import { chainParts, crossings } from './chain_marks.ts';
import { svg } from './dom.ts';

const kMinPixels = 3;
const kRim = 2.5; // both sides together [pixels]
const kFarAway: Vec3 = [1e9, 1e9, 1e9]; // an eye outside of all shafts

export function catheterMarks({ vessel, store }: Session, plane: SectionPlane): SVGElement[] {
    if (!vessel || !hasVessel(store.state)) return [];
    return chainMarks('catheter', vessel.catheter, vessel.radius, plane);
}

export function shaftMarks({ volume, stage, store }: Session, plane: SectionPlane): SVGElement[] {
    if (!volume || !stage.balls.length) return [];
    const { camera } = store.state.view;
    const lumen = lumenOf(volume, camera, surfaceOf(store.state));
    return stage.balls.flatMap((ball) => {
        const { base, wrist, thickness } = instrumentOf(ball, camera, lumen, kFarAway);
        const chain = [base, wrist, ball.centre];
        return chainMarks(ball.own ? 'shaft own' : 'shaft', chain, thickness, plane);
    });
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
    const r = Math.max(0.5 * wide, kMinPixels);
    const dots = crossings(points, plane).map(([cx, cy]) =>
        svg('circle', { class: 'pierced', cx, cy, r }),
    );
    return [...lines('rim', kRim), ...lines(kind, 0), ...dots];
}
