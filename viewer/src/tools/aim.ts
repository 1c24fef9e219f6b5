// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Picking: world positions under the pointer, in all views.

import { blendAlong } from '../maths/blend.ts';
import { voxelFromWorld } from '../maths/grid.ts';
import { firstHit, frameOf, inTissue, rayThrough, type Surface } from '../maths/rays.ts';
import { adjusted } from '../maths/transfer.ts';
import { along, dot, sub, type Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';
import { type State, surfaceOf, tipIsInScan, type View, type ViewName } from '../state/state.ts';
import { kOutsideField, orbitCamera } from '../views/orbit.ts';
import { planeUnder } from '../views/planes.ts';
import { sectionPlane, type SectionPlane, worldOfPixel } from '../views/section_geometry.ts';

/// Position in a view [CSS pixels from its top left corner].
export interface Spot {
    readonly view: ViewName;
    readonly x: number;
    readonly y: number;
    readonly width: number;
    readonly height: number;
}

export function planeAt(volume: VolumeData, state: State, spot: Spot): SectionPlane | undefined {
    if (spot.view === 'endoscope') return undefined;
    const { frames, cursor } = state.sections;
    const { view, width, height } = spot;
    return sectionPlane(volume.grid, view, frames[view], cursor, width, height);
}

/// Tests whether the endoscope's view shows the scan as a volume.
export const showsVolume = ({ outside, fluoroscopy, blended }: View): boolean =>
    outside && blended && !fluoroscopy;

/// Origin and direction of the ray through a spot of the endoscope's view.
export function rayAt(state: State, under: Spot): { origin: Vec3; direction: Vec3 } {
    const { rendering } = state;
    const { view, spot } = planeUnder(state, under);
    const u = (2 * spot.x - spot.width) / spot.height;
    const v = 1 - (2 * spot.y) / spot.height;
    if (!view.outside) {
        const { camera, fieldOfView, barrel } = view;
        return { origin: camera.eye, direction: rayThrough(camera, fieldOfView, barrel, u, v) };
    }
    const camera = orbitCamera(view);
    const direction = rayThrough(camera, kOutsideField, 0, u, v);
    const isCut = tipIsInScan(state) && (rendering.cut || !showsVolume(view));
    if (!isCut) return { origin: camera.eye, direction };
    // In the outside view rays begin at the plane through the tip that cuts the volume open.
    const ahead = dot(sub(view.camera.eye, camera.eye), camera.look);
    const start = Math.max(ahead / Math.max(dot(direction, camera.look), 1e-6), 0);
    return { origin: along(camera.eye, start, direction), direction };
}

/// World position under a spot; undefined if its ray hits no surface, or
/// loses less than half of its light in a volume.
export function pointAt(volume: VolumeData, state: State, spot: Spot): Vec3 | undefined {
    const plane = planeAt(volume, state, spot);
    if (plane) return worldOfPixel(plane, spot.x, spot.y);
    const { origin, direction } = rayAt(state, spot);
    if (showsVolume(state.view)) {
        const { transfer, opacity, shift } = state.rendering;
        return blendAlong(volume, adjusted(transfer, opacity, shift), origin, direction).picked;
    }
    return surfaceAt(volume, state, origin, direction)?.point;
}

/// First hit of a ray of rayAt with the surface that is shown: a wall, or tissue on the plane that
/// cuts the outside view open.
export function surfaceAt(
    volume: VolumeData,
    state: State,
    origin: Vec3,
    direction: Vec3,
): { readonly distance: number; readonly point: Vec3 } | undefined {
    const surface = surfaceOf(state);
    const { outside, fluoroscopy } = state.view;
    if (outside && !fluoroscopy && isTissueAt(volume, origin, surface))
        return { distance: 0, point: origin };
    return firstHit(volume, origin, direction, surface);
}

/// Tests whether a point is in the scan's tissue, as shaders/endoscope.frag.glsl does.
function isTissueAt(volume: VolumeData, point: Vec3, surface: Surface): boolean {
    const ijk = voxelFromWorld(volume.grid, point);
    const isInside = ijk.every((x, a) => x >= 0 && x <= volume.grid.size[a]! - 1);
    return isInside && inTissue(volume.sample(ijk), surface);
}

/// Axes of a view's picture and scale at a position, to convert drags to motions.
export function dragFrame(
    volume: VolumeData,
    state: State,
    spot: Spot,
    place: Vec3,
): { right: Vec3; up: Vec3; ahead: Vec3; mmPerPixel: number } {
    const plane = planeAt(volume, state, spot);
    if (plane) {
        const { right, up, normal } = plane.axes;
        return { right, up, ahead: normal, mmPerPixel: plane.mmPerPixel };
    }
    const { view, spot: inside } = planeUnder(state, spot);
    const { outside, fieldOfView } = view;
    const camera = outside ? orbitCamera(view) : view.camera;
    const field = outside ? kOutsideField : fieldOfView;
    const { right, up, forward } = frameOf(camera);
    const depth = Math.max(dot(sub(place, camera.eye), forward), 0.1);
    const slope = Math.tan((field * Math.PI) / 360);
    return { right, up, ahead: forward, mmPerPixel: (2 * depth * slope) / inside.height };
}
