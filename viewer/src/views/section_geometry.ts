// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Geometry of the sections in the radiological convention: patient's right on the left of the
// picture, anterior or head up, as in src/view/render/section.cpp.

import { type Grid, worldBounds } from '../maths/grid.ts';
import { add, along, dot, mul, sub, type Vec3 } from '../maths/vec.ts';
import type { SectionFrame, SectionName } from '../state/state.ts';

export interface SectionAxes {
    readonly right: Vec3;
    readonly up: Vec3;
    readonly normal: Vec3; ///< towards the viewer of the picture; scrolling forward moves along it
    readonly letters: string; ///< left, right, top, bottom
    readonly axis: 'x' | 'y' | 'z'; ///< world axis perpendicular to the section
}

export const kSectionAxes: Record<SectionName, SectionAxes> = {
    axial: { right: [1, 0, 0], up: [0, -1, 0], normal: [0, 0, 1], letters: 'RLAP', axis: 'z' },
    coronal: { right: [1, 0, 0], up: [0, 0, 1], normal: [0, 1, 0], letters: 'RLSI', axis: 'y' },
    sagittal: { right: [0, 1, 0], up: [0, 0, 1], normal: [1, 0, 0], letters: 'APSI', axis: 'x' },
};

export interface SectionPlane {
    readonly axes: SectionAxes;
    readonly centre: Vec3; ///< of the picture [mm, LPS]
    readonly mmPerPixel: number;
    readonly width: number; ///< [pixels]
    readonly height: number;
}

/// Plane of a section. @param cursor  point on the section [mm, LPS]
export function sectionPlane(
    grid: Grid,
    name: SectionName,
    frame: SectionFrame,
    cursor: Vec3,
    width: number,
    height: number,
): SectionPlane {
    const axes = kSectionAxes[name];
    const { low, high } = worldBounds(grid);
    const extent = sub(high, low);
    const whole = Math.max(
        Math.abs(dot(extent, axes.right)) / width,
        Math.abs(dot(extent, axes.up)) / height,
    );
    const middle = mul(0.5, add(low, high));
    let centre = along(middle, dot(sub(cursor, middle), axes.normal), axes.normal);
    centre = along(along(centre, frame.shift[0], axes.right), frame.shift[1], axes.up);
    return { axes, centre, mmPerPixel: whole / frame.zoom, width, height };
}

/// World position of a pixel. x, y: from the top left corner
export function worldOfPixel(plane: SectionPlane, x: number, y: number): Vec3 {
    const u = (x - 0.5 * plane.width) * plane.mmPerPixel;
    const v = (0.5 * plane.height - y) * plane.mmPerPixel;
    return along(along(plane.centre, u, plane.axes.right), v, plane.axes.up);
}

export function pixelOfWorld(plane: SectionPlane, point: Vec3): [number, number] {
    const v = sub(point, plane.centre);
    return [
        0.5 * plane.width + dot(v, plane.axes.right) / plane.mmPerPixel,
        0.5 * plane.height - dot(v, plane.axes.up) / plane.mmPerPixel,
    ];
}

/// Clamps a point to the volume along each world axis.
export function keptInside(grid: Grid, point: Vec3): Vec3 {
    const { low, high } = worldBounds(grid);
    return point.map((x, a) =>
        Math.min(Math.max(x, low[a]! + 1e-3), high[a]! - 1e-3),
    ) as unknown as Vec3;
}
