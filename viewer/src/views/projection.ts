// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Position of world points in the endoscope's view, from inside and from outside.

import { type Camera, frameOf } from '../maths/rays.ts';
import { dot, sub, type Vec3 } from '../maths/vec.ts';
import type { View } from '../state/state.ts';
import { kOutsideField, orbitCamera } from './orbit.ts';

const kNearest = 0.5; // depth of points that are drawn, in a body [mm]

/// Size of a view [CSS pixels].
export interface Extent {
    readonly width: number;
    readonly height: number;
}

/// Pixel of a point, from the top left corner; undefined behind the camera.
/// @param scale  of lengths: 1 in a body
export function spotInView(
    view: View,
    place: Vec3,
    box: Extent,
    scale = 1,
): [number, number] | undefined {
    const { camera, fieldOfView, barrel } = view;
    return view.outside
        ? project(orbitCamera(view), kOutsideField, 0, place, box, scale)
        : project(camera, fieldOfView, barrel, place, box, scale);
}

/// The lens's distortion is undone by Newton's method: r_ray = r·(1 + barrel·r²).
function project(
    camera: Camera,
    field: number,
    barrel: number,
    place: Vec3,
    { width, height }: Extent,
    scale: number,
): [number, number] | undefined {
    const { right, up, forward } = frameOf(camera);
    const v = sub(place, camera.eye);
    const depth = dot(v, forward);
    if (depth < scale * kNearest) return undefined;
    const slope = Math.tan((field * Math.PI) / 360);
    const a = dot(v, right) / depth / slope;
    const b = dot(v, up) / depth / slope;
    const bent = Math.hypot(a, b);
    let r = bent;
    for (let i = 0; i < 6; ++i) r -= (r * (1 + barrel * r * r) - bent) / (1 + 3 * barrel * r * r);
    const share = bent > 0 ? r / bent : 1;
    const half = height / 2;
    return [width / 2 + share * a * half, half - share * b * half];
}
