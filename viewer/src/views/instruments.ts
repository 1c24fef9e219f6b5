// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Where an instrument is: its head at the sphere of a tool, its shaft from the endoscope's working
// channel, below right of the lens. Others' instruments come from where their endoscope looks.
// shaders/instrument.glsl draws them.
//
// Seen along the shaft, jaws and blades would be points. So a head leans at the wrist, kLean away
// from the line of sight or as much as the lumen has room for; towards the wall that it touches,
// else as the shaft comes.

import { contact } from '../maths/flight.ts';
import { voxelFromWorld } from '../maths/grid.ts';
import { type Camera, firstHit, frameOf, type Surface } from '../maths/rays.ts';
import { add, along, cross, dot, mul, norm, normalized, sub, type Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';

/// Numbers as in the shader.
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
    readonly direction?: Vec3; ///< unit, from the shaft to the head; else it comes from the channel
}

export interface Instrument {
    readonly base: Vec3; ///< start of the shaft [mm, LPS]
    readonly wrist: Vec3; ///< its end
    readonly thickness: number; ///< radius of the shaft [mm]; 0: the eye is in it
    readonly axis: Vec3; ///< unit, of the head, away from the wrist
    readonly side: Vec3; ///< unit, across the head and towards the lens
    readonly angle: number; ///< half the opening of the jaws [radians]; blades: 1 or −1, see shader
}

/// The lumen around a camera, as far as an instrument has to know it.
export interface Lumen {
    readonly room: number; ///< free way from the lens towards the working channel's end [mm]
    /// Out of the wall that a sphere touches; shorter than 1 where it touches little of one.
    readonly out: (centre: Vec3, radius: number) => Vec3;
    readonly excess: (place: Vec3) => number; ///< above 0 in tissue [HU]
}

export const kBladeRadius = 2.5; // of a head whose tool is a line [mm]
const kChannel = { right: 3.2, up: -3, ahead: -1 } as const; // from the lens [mm]
const kShaftShare = 0.26; // of the head's radius
const kMostThickness = 0.6; // [mm]
const kLeastThickness = 0.2;
const kFreeLength = 60; // of a shaft whose endoscope is elsewhere [mm]
const kOpen = 0.5;
const kClosed = -0.03; // tips that touch
const kLean = (58 * Math.PI) / 180;
const kLeastLean = (22 * Math.PI) / 180;
const kLeans = 6; // that are tried
const kShaftFree = 2; // of the shaft, behind the wrist [mm]
const kMostTurn = (75 * Math.PI) / 180; // of a head about the line of sight, from its shaft
const kTowardsWall = 2; // weight of the wall against the shaft's own way
/// From the wrist to the sphere's centre, in radii.
const kReach: Record<ToolKind, number> = { ball: 0, grasper: 1.55, blade: 2, scoop: 0.8, scope: 0 };

/// Start of the working channel's instruments. room: free way from the eye towards it [mm]
export function channelOf(camera: Camera, size: number, room: number): Vec3 {
    const offset = channelOffset(camera);
    const share = Math.min(1, size, (0.8 * room) / norm(offset));
    return along(camera.eye, share, offset);
}

export function channelOffset(camera: Camera): Vec3 {
    const { right, up, forward } = frameOf(camera);
    return add(add(mul(kChannel.right, right), mul(kChannel.up, up)), mul(kChannel.ahead, forward));
}

export function lumenOf(volume: VolumeData, camera: Camera, surface: Surface): Lumen {
    const hit = firstHit(volume, camera.eye, channelOffset(camera), surface, 10);
    return {
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

/// v without its part along a unit vector.
const across = (v: Vec3, unit: Vec3): Vec3 => along(v, -dot(v, unit), unit);

/// @param camera  of the endoscope, also where the picture is from outside
/// @param eye  of the picture
export function instrumentOf(ball: ToolBall, camera: Camera, lumen: Lumen, eye: Vec3): Instrument {
    const { centre, radius, kind, direction } = ball;
    const scope = kind === 'scope';
    const share = scope ? 0.85 : kShaftShare;
    const most = scope ? Infinity : kMostThickness;
    let thickness = Math.max(Math.min(share * radius, most), kLeastThickness);
    const base = direction
        ? along(centre, -kFreeLength, direction)
        : channelOf(camera, radius / 2, lumen.room);
    const shaft = normalized(sub(centre, base));
    const reach = kReach[kind] * radius;
    const out = reach > 0 ? lumen.out(centre, radius) : shaft;
    const ray = normalized(sub(centre, camera.eye));
    const axis = reach > 0 ? freeLean(shaft, ray, out, centre, reach, lumen) : shaft;
    const wrist = along(centre, -reach, axis);
    // Towards the lens: flat heads and open ones show themselves.
    let side = across(sub(camera.eye, wrist), axis);
    if (norm(side) < 1e-3) side = cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]);
    side = normalized(side);
    if (norm(sub(wrist, base)) < 1e-3 || distanceToSegment(eye, base, wrist) < 1.2 * thickness)
        thickness = 0;
    const jaws = ball.closed ? kClosed : kOpen;
    const edge = dot(cross(axis, side), out) < 0 ? -1 : 1; // the blade's edge is at the wall
    return { base, wrist, thickness, axis, side, angle: kind === 'blade' ? edge : jaws };
}

/// The axis of a head, which leans as far as its wrist is out of the tissue.
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
        const places = [wrist, along(centre, -0.6 * reach, axis), along(wrist, -kShaftFree, shaft)];
        return Math.max(...places.map(lumen.excess));
    };
    const most = Math.max(natural, kLean);
    let [lean, excess] = [most, excessAt(most)];
    for (let n = 1; n < kLeans && excess > 0; ++n) {
        const next = most + (n / (kLeans - 1)) * (kLeastLean - most);
        const there = excessAt(next);
        // Linear between two that were tried, so that the head doesn't leap.
        if (there <= 0) return axisAt(next + (there / (there - excess)) * (lean - next));
        [lean, excess] = [next, there];
    }
    return axisAt(lean);
}

/// Across the line of sight, where a head leans. @param ray  from the lens to it, unit
function asideOf(shaft: Vec3, ray: Vec3, out: Vec3): Vec3 {
    const own = across(shaft, ray);
    const ahead = normalized(norm(own) > 1e-3 ? own : across([0.6, 0.64, 0.48], ray));
    const beside = cross(ray, ahead);
    const wished = along(own, -kTowardsWall, across(out, ray));
    // A head that folded back would be behind its shaft. The sign keeps to one side of straight.
    const [x, y] = [dot(wished, ahead), dot(wished, beside)];
    const turn = Math.min(Math.acos(Math.min(Math.max(x / norm([x, y, 1e-9]), -1), 1)), kMostTurn);
    const sign = y < -0.3 * norm(wished) || (x > 0 && y < 0) ? -1 : 1;
    return along(mul(Math.cos(turn), ahead), sign * Math.sin(turn), beside);
}

export function distanceToSegment(p: Vec3, a: Vec3, b: Vec3): number {
    const ab = sub(b, a);
    const share = dot(sub(p, a), ab) / Math.max(dot(ab, ab), 1e-12);
    return norm(sub(p, along(a, Math.min(Math.max(share, 0), 1), ab)));
}
