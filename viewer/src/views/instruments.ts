// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pose of an instrument: the head at the sphere of a tool, the shaft from the endoscope's working
// channel, below right of the lens. Instruments of other clients come from the direction of their
// endoscopes. shaders/instrument.glsl draws them.
//
// Seen along the shaft, jaws and blades would be points. So a head leans at the wrist: by kLean
// from the line of sight, or as far as the lumen has room; towards the wall that it touches, else
// as the shaft.

import { contact } from '../maths/flight.ts';
import { voxelFromWorld } from '../maths/grid.ts';
import { type Camera, firstHit, frameOf, type Surface } from '../maths/rays.ts';
import { add, along, cross, dot, mul, norm, normalized, sub, type Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';

/// Numbers of the kinds in the shader.
export const kKinds = { ball: 0, grasper: 1, blade: 2, scoop: 3, scope: 4 } as const;
export type ToolKind = keyof typeof kKinds;

/// Heads of the tools that touch tissue.
export const kHeads: Readonly<Record<string, ToolKind>> = {
    push: 'ball',
    grab: 'grasper',
    cut: 'blade',
    carve: 'scoop',
};

export interface ToolBall {
    readonly centre: Vec3;
    readonly radius: number;
    readonly own: boolean;
    readonly kind: ToolKind;
    readonly closed?: boolean; ///< jaws hold something
    readonly direction?: Vec3; ///< unit, of the shaft; absent: from the channel
}

export interface Instrument {
    readonly base: Vec3; ///< start of the shaft [mm, LPS]
    readonly wrist: Vec3; ///< its end
    readonly thickness: number; ///< radius of the shaft [mm]; 0: the eye is inside
    readonly axis: Vec3; ///< unit, of the head, away from the wrist
    readonly side: Vec3; ///< unit, across the head and towards the lens
    readonly angle: number; ///< half opening of the jaws [radians]; side of a blade: 1 or −1
}

/// Free space of the lumen around a camera.
export interface Lumen {
    readonly scale: number; ///< of instruments: 1 in a body
    readonly room: number; ///< distance from the lens to the wall, towards the working channel [mm]
    /// Direction out of the wall that a sphere touches; shorter than 1 for little contact.
    readonly out: (centre: Vec3, radius: number) => Vec3;
    readonly excess: (place: Vec3) => number; ///< positive in tissue [HU]
}

// Lengths in a body.
export const kBladeRadius = 2.5; // of a head whose tool is a line [mm]
const kChannel = { right: 3.2, up: -3, ahead: -1 } as const; // from the lens [mm]
const kShaftShare = 0.26; // radius of the shaft over that of the head
const kMaxThickness = 0.6; // [mm]
const kMinThickness = 0.2;
const kFreeLength = 60; // of the shafts of other clients [mm]
const kOpen = 0.5;
const kClosed = -0.03; // the tips touch
const kLean = (58 * Math.PI) / 180;
const kMinLean = (22 * Math.PI) / 180;
const kLeans = 6; // number of angles to try
const kShaftFree = 2; // length of shaft behind the wrist that is kept out of tissue [mm]
const kMaxTurn = (75 * Math.PI) / 180; // of a head about the line of sight, relative to its shaft
const kCoveredShares = [0.1, 0.2] as const; // of the field: a head becomes translucent
const kClear = 0.25; // opacity of a translucent head
const kTowardsWall = 2; // weight of the wall's direction over the shaft's
/// Distance from the wrist to the sphere's centre [radii].
const kReach: Record<ToolKind, number> = { ball: 0, grasper: 1.55, blade: 2, scoop: 0.8, scope: 0 };

/// Start of an instrument in the working channel. @param size  of the instrument [mm]
export function channelOf(camera: Camera, size: number, { room, scale }: Lumen): Vec3 {
    const offset = mul(scale, channelOffset(camera));
    const share = Math.min(1, size / scale, (0.8 * room) / norm(offset));
    return along(camera.eye, share, offset);
}

/// Offset of the working channel from the lens, in a body [mm].
export function channelOffset(camera: Camera): Vec3 {
    const { right, up, forward } = frameOf(camera);
    return add(add(mul(kChannel.right, right), mul(kChannel.up, up)), mul(kChannel.ahead, forward));
}

/// Opacity of a head: a probe that covers much of the endoscope's round field is translucent, so
/// that the dent behind it is seen. @param fieldOfView  [degrees]
export function headOpacity(
    { kind, centre, radius }: ToolBall,
    eye: Vec3,
    fieldOfView: number,
): number {
    if (kind !== 'ball') return 1;
    const distance = norm(sub(centre, eye));
    const beside = Math.sqrt(Math.max(distance ** 2 - radius ** 2, 1e-9));
    const covered = (radius / beside / Math.tan((fieldOfView * Math.PI) / 360)) ** 2;
    const [begin, end] = kCoveredShares;
    const share = Math.min(Math.max((covered - begin) / (end - begin), 0), 1);
    return 1 - share * (1 - kClear);
}

export function lumenOf(
    volume: VolumeData,
    camera: Camera,
    surface: Surface,
    scale: number,
): Lumen {
    const hit = firstHit(volume, camera.eye, channelOffset(camera), surface, 10 * scale);
    return {
        scale,
        room: hit?.distance ?? Infinity,
        out: (centre, radius) => {
            const { out } = contact(volume, centre, radius, surface);
            return mul(1 / Math.max(norm(out), 3), out);
        },
        excess: (place) => {
            const above = volume.sample(voxelFromWorld(volume.grid, place)) - surface.iso;
            return surface.rising ? above : -above;
        },
    };
}

/// Component of v perpendicular to a unit vector.
const across = (v: Vec3, unit: Vec3): Vec3 => along(v, -dot(v, unit), unit);

/// Pose of an instrument.
/// @param camera  of the endoscope, also for the outside view
/// @param eye  of the picture
export function instrumentOf(ball: ToolBall, camera: Camera, lumen: Lumen, eye: Vec3): Instrument {
    const { centre, radius, kind, direction } = ball;
    const scope = kind === 'scope';
    const share = scope ? 0.85 : kShaftShare;
    const { scale } = lumen;
    const most = scope ? Infinity : scale * kMaxThickness;
    let thickness = Math.max(Math.min(share * radius, most), scale * kMinThickness);
    const base = direction
        ? along(centre, -scale * kFreeLength, direction)
        : channelOf(camera, radius / 2, lumen);
    const shaft = normalized(sub(centre, base));
    const reach = kReach[kind] * radius;
    const out = reach > 0 ? lumen.out(centre, radius) : shaft;
    const ray = normalized(sub(centre, camera.eye));
    const axis = reach > 0 ? freeLean(shaft, ray, out, centre, reach, lumen) : shaft;
    const wrist = along(centre, -reach, axis);
    // Towards the lens, so that flat and open heads are recognisable.
    let side = across(sub(camera.eye, wrist), axis);
    if (norm(side) < 1e-3) side = cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]);
    side = normalized(side);
    if (
        norm(sub(wrist, base)) < 1e-3 * scale ||
        distanceToSegment(eye, base, wrist) < 1.2 * thickness
    )
        thickness = 0;
    const jaws = ball.closed ? kClosed : kOpen;
    const edge = dot(cross(axis, side), out) < 0 ? -1 : 1; // the blade's edge is at the wall
    return { base, wrist, thickness, axis, side, angle: kind === 'blade' ? edge : jaws };
}

/// Axis of a head at the largest angle that keeps its wrist out of tissue.
function freeLean(
    shaft: Vec3,
    ray: Vec3,
    out: Vec3,
    centre: Vec3,
    reach: number,
    lumen: Lumen,
): Vec3 {
    const aside = asideOf(shaft, ray, out);
    const natural = Math.acos(Math.min(dot(shaft, ray), 1));
    const axisAt = (lean: number): Vec3 =>
        add(mul(Math.cos(lean), ray), mul(Math.sin(lean), aside));
    const excessAt = (lean: number): number => {
        const axis = axisAt(lean);
        const wrist = along(centre, -reach, axis);
        const behind = along(wrist, -lumen.scale * kShaftFree, shaft);
        const places = [wrist, along(centre, -0.6 * reach, axis), behind];
        return Math.max(...places.map(lumen.excess));
    };
    const most = Math.max(natural, kLean);
    let [lean, excess] = [most, excessAt(most)];
    for (let n = 1; n < kLeans && excess > 0; ++n) {
        const next = most + (n / (kLeans - 1)) * (kMinLean - most);
        const there = excessAt(next);
        // Interpolated between two angles, so that the head moves continuously.
        if (there <= 0) return axisAt(next + (there / (there - excess)) * (lean - next));
        [lean, excess] = [next, there];
    }
    return axisAt(lean);
}

/// Direction across the line of sight in which a head leans. @param ray  from the lens to it, unit
function asideOf(shaft: Vec3, ray: Vec3, out: Vec3): Vec3 {
    const own = across(shaft, ray);
    const ahead = normalized(norm(own) > 1e-3 ? own : across([0.6, 0.64, 0.48], ray));
    const beside = cross(ray, ahead);
    const wished = along(own, -kTowardsWall, across(out, ray));
    // A head that folds back would be hidden by its shaft. The sign is stable near the opposite
    // direction.
    const [x, y] = [dot(wished, ahead), dot(wished, beside)];
    const turn = Math.min(Math.acos(Math.min(Math.max(x / norm([x, y, 1e-9]), -1), 1)), kMaxTurn);
    const sign = y < -0.3 * norm(wished) || (x > 0 && y < 0) ? -1 : 1;
    return along(mul(Math.cos(turn), ahead), sign * Math.sin(turn), beside);
}

export function distanceToSegment(p: Vec3, a: Vec3, b: Vec3): number {
    const ab = sub(b, a);
    const share = dot(sub(p, a), ab) / Math.max(dot(ab, ab), 1e-12);
    return norm(sub(p, along(a, Math.min(Math.max(share, 0), 1), ab)));
}
