// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Drawings of marks over the views: points, lines with their values, the section of the lumen at
// the tip, warnings, and bars of scale. Marks beyond a slice or behind a wall are faint.

import { kPointsOf, type Mark, valueOf } from '../maths/marks.ts';
import { firstHit } from '../maths/rays.ts';
import { stepUpTo } from '../maths/steps.ts';
import { dot, norm, sub, type Vec3 } from '../maths/vec.ts';
import { surfaceOf, type View } from '../state/state.ts';
import { scaleOf } from '../state/units.ts';
import type { Session } from '../tools/session.ts';
import { type Extent, spotInView } from '../views/projection.ts';
import { pixelOfWorld, type SectionPlane } from '../views/section_geometry.ts';
import { svg } from './dom.ts';

// Lengths in a body.
const kNear = 2; // distance from a slice up to which a mark is drawn strong [mm]
const kBehind = 1; // depth behind a wall from which a mark is faint [mm]
const kHandle = 4; // radius of a point [pixels]

type Spot = readonly [number, number];

/// Where and how a view shows a point.
interface Seen {
    readonly spot: Spot | undefined;
    readonly near: boolean;
}

export function marksInSection(session: Session, plane: SectionPlane): SVGElement[] {
    const near = scaleOf(session.store.state.scan.volume) * kNear;
    const seen = (place: Vec3): Seen => ({
        spot: pixelOfWorld(plane, place),
        near: Math.abs(dot(sub(place, plane.centre), plane.axes.normal)) <= near,
    });
    return [
        ...lumenMarks(session, plane),
        ...allMarks(session, seen),
        ...riskMarks(session, (place) => pixelOfWorld(plane, place), 1 / plane.mmPerPixel),
        ...scaleBar(plane.mmPerPixel, plane.width, plane.height),
    ];
}

export function marksInEndoscope(session: Session, view: View, box: Extent): SVGElement[] {
    const { state } = session.store;
    const { volume } = session;
    if (!volume) return [];
    const { eye } = view.camera;
    const scale = scaleOf(state.scan.volume);
    const behind = scale * kBehind;
    const seen = (place: Vec3, isOne: boolean): Seen => {
        const spot = spotInView(view, place, box, scale);
        if (!spot || !isOne || view.outside) return { spot, near: true };
        const way = sub(place, eye);
        const reach = norm(way);
        const hit = firstHit(volume, eye, way, surfaceOf(state), reach);
        return { spot, near: !hit || hit.distance > reach - behind };
    };
    return [
        ...allMarks(session, seen),
        ...riskMarks(session, (place) => spotInView(view, place, box, scale), 0),
    ];
}

const kRing = 14; // least radius of a warning [pixels]

/// Warning at the own tools while they touch a structure at risk.
function riskMarks(
    session: Session,
    spotOf: (place: Vec3) => Spot | undefined,
    pixelsPerMm: number,
): SVGElement[] {
    const { touched } = session.store.state.labels;
    if (!touched.length) return [];
    return session.stage.balls
        .filter((ball) => ball.own)
        .flatMap(({ centre, radius }) => {
            const spot = spotOf(centre);
            if (!spot) return [];
            const [cx, cy] = spot;
            const r = Math.max(radius * pixelsPerMm + 4, kRing);
            const label = svg('text', { class: 'risk', x: cx + r + 4, y: cy + 4 });
            label.textContent = `touches ${touched.join(', ')}`;
            return [svg('circle', { class: 'risk', cx, cy, r }), label];
        });
}

/// How a view shows a point. @param isOne  it is no point of a curve, which may have many
type See = (place: Vec3, isOne: boolean) => Seen;

function allMarks(session: Session, seen: See): SVGElement[] {
    const { list, selected } = session.store.state.marks;
    const shown = list.filter((mark) => mark.shown);
    return [
        ...shown.flatMap((mark) => oneMark(mark, session, seen, mark.key === selected)),
        ...pendingMark(session, seen),
    ];
}

function oneMark(mark: Mark, session: Session, seen: See, own: boolean): SVGElement[] {
    const points = session.marks.present(mark);
    const places = points.map((place) => seen(place, mark.kind !== 'curve'));
    const near = places.some((place) => place.near);
    const kind = `mark${near ? ' near' : ''}${own ? ' chosen' : ''}`;
    const spots = places.flatMap(({ spot }) => (spot ? [spot] : []));
    if (!spots.length) return [];
    const value = valueOf(mark.kind, points);
    const label = value ? session.marks.valueText(value) : mark.name;
    const handles = mark.kind === 'curve' ? [] : spots;
    // An angle has its value at the vertex, others in the middle.
    const at = mark.kind === 'angle' ? places[1]!.spot : middle(spots);
    return [
        ...lines(kind, spots),
        ...handles.map(([cx, cy]) => svg('circle', { class: kind, cx, cy, r: kHandle })),
        ...(at ? [text(kind, at, label)] : []),
    ];
}

/// A mark without its last points, with a line to the pointer.
function pendingMark(session: Session, seen: See): SVGElement[] {
    const { marks, pointer, tool } = session.store.state;
    if (!marks.pending.length || tool.name !== 'measure') return [];
    const set = marks.pending.map((rest) => session.marks.presentPoint(rest));
    const ahead = pointer.under?.point;
    const places = ahead ? [...set, ahead] : set;
    const spots = places.flatMap((place) => {
        const { spot } = seen(place, false);
        return spot ? [spot] : [];
    });
    const whole = places.length === kPointsOf[marks.kind];
    const value = whole ? valueOf(marks.kind, places) : undefined;
    if (!spots.length) return [];
    return [
        ...lines('mark near pending', spots),
        ...spots.map(([cx, cy]) =>
            svg('circle', { class: 'mark near pending', cx, cy, r: kHandle }),
        ),
        ...(value
            ? [text('mark near', spots[spots.length - 1]!, session.marks.valueText(value))]
            : []),
    ];
}

function lines(kind: string, spots: readonly Spot[]): SVGElement[] {
    if (spots.length < 2) return [];
    const points = spots.map((spot) => spot.join(',')).join(' ');
    return [
        svg('polyline', { class: 'mark rim', points }),
        svg('polyline', { class: kind, points }),
    ];
}

const middle = (spots: readonly Spot[]): Spot => {
    const [a, b] = [spots[0]!, spots[spots.length - 1]!];
    return spots.length === 2 ? [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2] : spots[spots.length >> 1]!;
};

function text(kind: string, [x, y]: Spot, label: string): SVGElement {
    const element = svg('text', { class: kind, x: x + 8, y: y - 7 });
    element.textContent = label;
    return element;
}

/// Border of the lumen's section at the tip, projected.
function lumenMarks(session: Session, plane: SectionPlane): SVGElement[] {
    const { tip } = session.store.state.lumen;
    if (!tip || tip === 'open') return [];
    const pieces = tip.border.map(([a, b]) => {
        const [from, to] = [pixelOfWorld(plane, a), pixelOfWorld(plane, b)];
        const text = (spot: Spot): string => spot.map((x) => x.toFixed(1)).join(' ');
        return `M${text(from)}L${text(to)}`;
    });
    return [svg('path', { class: 'mark near lumen', d: pieces.join('') })];
}

const kLongestBar = 110; // [pixels]
const kBarShare = 0.3; // of a small view: the letter in the middle stays free

/// Length of a bar of scale in a view of a width [mm].
const barLength = (mmPerPixel: number, width: number): number =>
    stepUpTo(Math.min(kLongestBar, kBarShare * width) * mmPerPixel);

function scaleBar(mmPerPixel: number, width: number, height: number): SVGElement[] {
    const mm = barLength(mmPerPixel, width);
    const long = mm / mmPerPixel;
    const [right, y] = [width - 10, height - 7];
    const d = `M${right - long} ${y - 4}V${y}H${right}V${y - 4}`;
    const label = svg('text', { class: 'scale', x: right, y: y - 7 });
    label.textContent = mm >= 10 && mm % 10 === 0 ? `${mm / 10} cm` : `${mm} mm`;
    return [
        svg('path', { class: 'scale rim', d }),
        svg('path', { class: 'scale', d, 'data-mm': mm }),
        label,
    ];
}
