// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Names of the users at their tools and endoscopes, in all views.

import { firstHit } from '../maths/rays.ts';
import { dot, norm, sub, type Vec3 } from '../maths/vec.ts';
import { nameOfClient } from '../state/company.ts';
import { type State, surfaceOf, type View } from '../state/state.ts';
import { scaleOf } from '../state/units.ts';
import type { Session } from '../tools/session.ts';
import { type Extent, spotInView } from '../views/projection.ts';
import { pixelOfWorld, type SectionPlane } from '../views/section_geometry.ts';
import { svg } from './dom.ts';

const kLongest = 18; // characters of a name
const kNear = 2; // distance beyond a tool from which its name is faint, in a body [mm]
const kLine = 15; // height of a name [pixels]
const kLetter = 7; // width of a letter, roughly [pixels]
const kAside = 9; // distance from the tool [pixels]

type Spot = readonly [number, number];

interface Named {
    readonly name: string;
    readonly spot: Spot;
    readonly near: boolean;
}

export function namesInSection({ store }: Session, plane: SectionPlane): SVGElement[] {
    const near = scaleOf(store.state.scan.volume) * kNear;
    const names = toolsOf(store.state).map(({ name, position, radius }) => {
        const off = Math.abs(dot(sub(position, plane.centre), plane.axes.normal));
        return { name, spot: pixelOfWorld(plane, position), near: off <= radius + near };
    });
    return labels(names, plane);
}

export function namesInEndoscope(
    { store, volume }: Session,
    view: View,
    box: Extent,
): SVGElement[] {
    const { state } = store;
    const { eye } = view.camera;
    const isHidden = (position: Vec3, radius: number): boolean => {
        const way = sub(position, eye);
        const reach = norm(way) - radius;
        return !!volume && reach > 0 && !!firstHit(volume, eye, way, surfaceOf(state), reach);
    };
    const names = toolsOf(state).flatMap(({ name, position, radius }): Named[] => {
        const spot = spotInView(view, position, box, scaleOf(state.scan.volume));
        if (!spot || (!view.outside && isHidden(position, radius))) return [];
        return [{ name, spot, near: true }];
    });
    return labels(names, box);
}

function toolsOf(state: State): { name: string; position: Vec3; radius: number }[] {
    const { hands, company, device, shared, link } = state;
    if (!company.names) return [];
    const { news } = device;
    return hands.others.flatMap(({ client, position, radius }) => {
        // A device is a client of its own.
        const owner = news?.on && news.tool === client ? (news.client ?? client) : client;
        const name = nameOfClient(shared, owner);
        const short = name.length > kLongest ? `${name.slice(0, kLongest - 1)}…` : name;
        return owner === link.client ? [] : [{ name: short, position, radius }];
    });
}

/// Names beside their tools, inside of the view, and below each other where they would overlap.
function labels(names: readonly Named[], { width, height }: Extent): SVGElement[] {
    const taken: { left: number; right: number; y: number }[] = [];
    return names
        .filter(({ spot: [x, y] }) => x >= 0 && y >= 0 && x <= width && y <= height)
        .map(({ name, spot, near }) => {
            const long = kLetter * name.length;
            const isRight = spot[0] + kAside + long > width;
            const x = isRight ? spot[0] - kAside : spot[0] + kAside;
            const [left, right] = isRight ? [x - long, x] : [x, x + long];
            let y = Math.max(spot[1] - kAside, kLine);
            while (taken.some((t) => left < t.right && t.left < right && Math.abs(t.y - y) < kLine))
                y += kLine;
            taken.push({ left, right, y });
            const anchor = isRight ? 'end' : 'start';
            const label = svg('text', {
                class: near ? 'user near' : 'user',
                x,
                y,
                'text-anchor': anchor,
            });
            label.textContent = name;
            return label;
        });
}
