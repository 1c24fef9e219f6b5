// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Initial cameras of a scene with a catheter: the outside view shows the whole vessel from its
// broad side; the endoscope is behind the catheter's tip and looks at it. An endoscope that rides
// on the tip has the same camera, with directions that change smoothly.

import { type Camera, firstHit, naturalUp, type Surface } from '../maths/rays.ts';
import { add, along, cross, dot, mul, norm, normalized, sub, type Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';
import type { Vessel } from '../net/vessel.ts';
import type { Orbit } from '../state/state.ts';

const kBehind = 9; // distance of the eye behind the tip [mm]
const kAside = 3; // largest distance of the eye to the catheter's surface [mm]
const kAhead = 4; // distance of the target ahead of the tip [mm]
const kRideAhead = 12; // the same for an endoscope that rides on the tip [mm]
const kKeptSide = 1.5; // factor of the room on the side where the eye is already
const kSides = 12;
const kMargin = 1.15;

/// Outside view of the whole vessel. @param slope  tangent of half the field of view
export function outsideOf(vessel: Vessel, slope: number): Orbit {
    const nodes: Vec3[] = [...vessel.catheter];
    const { rest } = vessel;
    for (let n = 0; n < rest.length; n += 3) nodes.push([rest[n]!, rest[n + 1]!, rest[n + 2]!]);
    const [thin, , long] = principalAxes(nodes);
    const direction = thin[1] < 0 ? mul(-1, thin) : thin; // from the front if possible
    const head = along([0, 0, 1], -direction[2], direction);
    const flat = norm(head) > 0.3 ? head : long;
    const up = normalized(along(flat, -dot(flat, direction), direction));
    const right = cross(direction, up);
    const [x, y, z] = [right, up, direction].map((axis) => {
        const places = nodes.map((p) => dot(p, axis));
        const low = places.reduce((a, b) => Math.min(a, b));
        const high = places.reduce((a, b) => Math.max(a, b));
        return { axis, middle: 0.5 * (low + high), half: 0.5 * (high - low) };
    }) as [Extent, Extent, Extent];
    const centre = [x, y, z].map((e) => mul(e.middle, e.axis)).reduce(add);
    const distance = z.half + (kMargin * Math.max(x.half, y.half)) / slope;
    return { centre, direction, up, distance };
}

interface Extent {
    readonly axis: Vec3;
    readonly middle: number;
    readonly half: number;
}

/// Camera behind the catheter's tip. @returns undefined if the lumen has no room beside the
/// catheter
export function behindTip(
    vessel: Vessel,
    volume: VolumeData,
    surface: Surface,
): Camera | undefined {
    const spot = besideCatheter(vessel, volume, surface);
    if (!spot) return undefined;
    const { eye, place, tip } = spot;
    const look = normalized(sub(along(tip, kAhead, normalized(sub(tip, place))), eye));
    return { eye, look, up: naturalUp(look) };
}

/// Camera of an endoscope that rides on the catheter's tip: behind it, looking along the tip's
/// tangent. It stays on its side of the catheter unless another one has far more room, and keeps
/// its roll. @param before  the present camera
export function onTip(
    vessel: Vessel,
    volume: VolumeData,
    surface: Surface,
    before: Camera,
): Camera | undefined {
    const spot = besideCatheter(vessel, volume, surface, before.eye);
    if (!spot) return undefined;
    const { eye, tip, tangent } = spot;
    const look = normalized(sub(along(tip, kRideAhead, tangent), eye));
    const up = along(before.up, -dot(before.up, look), look);
    return { eye, look, up: norm(up) > 0.1 ? normalized(up) : naturalUp(look) };
}

/// Eye beside the catheter, kBehind before its tip, on the side with most room.
/// @param kept  position of an eye whose side is preferred
function besideCatheter(
    { catheter, radius }: Vessel,
    volume: VolumeData,
    surface: Surface,
    kept?: Vec3,
): { eye: Vec3; place: Vec3; tip: Vec3; tangent: Vec3 } | undefined {
    const last = catheter.length - 1;
    if (last < 1) return undefined;
    const tip = catheter[last]!;
    let n = last;
    let way = 0;
    for (; n > 0 && way < kBehind; --n) way += norm(sub(catheter[n]!, catheter[n - 1]!));
    const place = catheter[n]!;
    const axis = normalized(sub(catheter[n + 1]!, place));
    const roomAt = (aside: Vec3): number =>
        firstHit(volume, place, aside, surface, 50)?.distance ?? 50;
    let first = normalized(cross(axis, Math.abs(axis[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0]));
    let [room, side, worth] = [0, first, 0];
    const away = kept && sub(kept, place);
    const present = away && along(away, -dot(away, axis), axis);
    if (present && norm(present) > 0.1) {
        first = side = normalized(present);
        room = roomAt(side);
        worth = kKeptSide * room;
    }
    const second = cross(axis, first);
    for (let k = 0; k < kSides; ++k) {
        const angle = (2 * Math.PI * k) / kSides;
        const aside = add(mul(Math.cos(angle), first), mul(Math.sin(angle), second));
        const free = roomAt(aside);
        if (free > worth + 0.1) [room, side, worth] = [free, aside, free];
    }
    if (room < radius + 0.6) return undefined;
    const off = Math.min(0.5 * (room - radius), kAside, Math.max(0.5 * way, 0.5));
    const eye = along(place, radius + off, side);
    return { eye, place, tip, tangent: normalized(sub(tip, catheter[last - 1]!)) };
}

/// Principal axes of points, by ascending variance, by Jacobi rotations.
export function principalAxes(places: readonly Vec3[]): [Vec3, Vec3, Vec3] {
    const middle = mul(1 / places.length, places.reduce(add));
    const c = [0, 1, 2].map(() => [0, 0, 0]);
    for (const p of places) {
        const v = sub(p, middle);
        for (let i = 0; i < 3; ++i) for (let j = 0; j < 3; ++j) c[i]![j]! += v[i]! * v[j]!;
    }
    const axes: number[][] = [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
    ];
    for (let sweep = 0; sweep < 12; ++sweep)
        for (const [p, q] of [
            [0, 1],
            [0, 2],
            [1, 2],
        ] as const) {
            const angle = 0.5 * Math.atan2(2 * c[p]![q]!, c[p]![p]! - c[q]![q]!);
            const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
            const turn = (a: number, b: number): [number, number] => [
                cos * a + sin * b,
                cos * b - sin * a,
            ];
            for (const row of c) [row[p], row[q]] = turn(row[p]!, row[q]!);
            for (let k = 0; k < 3; ++k) [c[p]![k], c[q]![k]] = turn(c[p]![k]!, c[q]![k]!);
            for (const row of axes) [row[p], row[q]] = turn(row[p]!, row[q]!);
        }
    const order = [0, 1, 2].sort((i, j) => c[i]![i]! - c[j]![j]!);
    return order.map((i) => axes.map((row) => row[i]!)) as unknown as [Vec3, Vec3, Vec3];
}
