// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Where an instrument is: its head in the sphere of a tool, its shaft from the endoscope's working
// channel, below right of the lens. Others' instruments come from where their endoscope looks.
// shaders/instrument.glsl draws them.

import { type Camera, frameOf } from './rays.ts';
import { add, along, cross, dot, mul, norm, normalized, sub, type Vec3 } from './vec.ts';

/// Numbers as in the shader.
export const kKinds = { ball: 0, grasper: 1, blade: 2, scoop: 3, scope: 4 } as const;
export type ToolKind = keyof typeof kKinds;

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
    readonly thickness: number; ///< radius of the shaft [mm]; 0: the eye is in it
    readonly axis: Vec3; ///< unit, along the shaft towards the head
    readonly side: Vec3; ///< unit, across the shaft and towards the lens
    readonly angle: number; ///< half the opening of the jaws [radians]
}

export const kBladeRadius = 2; // of a head whose tool is a line [mm]
const kChannel = { right: 3.2, up: -3, ahead: -1 } as const; // from the lens [mm]
const kShaftShare = 0.26; // of the head's radius
const kMostThickness = 0.75; // [mm]
const kLeastThickness = 0.2;
const kFreeLength = 60; // of a shaft whose endoscope is elsewhere [mm]
const kOpen = 0.5;
const kClosed = 0.12;

/// Start of the working channel's instruments. room: free way from the eye towards it [mm]
export function channelOf(camera: Camera, size: number, room: number): Vec3 {
    const offset = channelOffset(camera);
    const share = Math.min(1, size, (0.8 * room) / norm(offset));
    return along(camera.eye, share, offset);
}

export function channelOffset(camera: Camera): Vec3 {
    const { right, up, forward } = frameOf(camera);
    return add(
        add(mul(kChannel.right, right), mul(kChannel.up, up)),
        mul(kChannel.ahead, forward),
    );
}

/// @param camera  of the endoscope, also where the picture is from outside
/// @param eye  of the picture
export function instrumentOf(ball: ToolBall, camera: Camera, room: number, eye: Vec3): Instrument {
    const scope = ball.kind === 'scope';
    const share = scope ? 0.85 : kShaftShare;
    const most = scope ? Infinity : kMostThickness;
    let thickness = Math.max(Math.min(share * ball.radius, most), kLeastThickness);
    const base = ball.direction
        ? along(ball.centre, -kFreeLength, ball.direction)
        : channelOf(camera, ball.radius / 2, room);
    const axis = normalized(sub(ball.centre, base));
    // Towards the lens: flat heads and open ones show themselves.
    const off = sub(camera.eye, base);
    let side = along(off, -dot(off, axis), axis);
    if (norm(side) < 1e-3) side = cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]);
    side = normalized(side);
    const length = norm(sub(ball.centre, base));
    if (length < 1e-3 || distanceToSegment(eye, base, ball.centre) < 1.2 * thickness) thickness = 0;
    return { base, thickness, axis, side, angle: ball.closed ? kClosed : kOpen };
}

export function distanceToSegment(p: Vec3, a: Vec3, b: Vec3): number {
    const ab = sub(b, a);
    const share = dot(sub(p, a), ab) / Math.max(dot(ab, ab), 1e-12);
    return norm(sub(p, along(a, Math.min(Math.max(share, 0), 1), ab)));
}
