// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Geometry of the voxel grid, as the server sends it:
//
//   world [mm, LPS] = origin + direction · diag(spacing) · ijk

import { add, apply, applyTransposed, type Mat3, sub, type Vec3 } from './vec.ts';

export interface Grid {
    readonly size: Vec3;
    readonly spacing: Vec3; ///< [mm]
    readonly origin: Vec3; ///< centre of voxel (0, 0, 0) [mm, LPS]
    readonly direction: Mat3; ///< columns: the axes i, j, k in LPS
}

/// Half-open: begin ≤ ijk < end.
export interface Box {
    readonly begin: Vec3;
    readonly end: Vec3;
}

export const isEmpty = (b: Box): boolean =>
    b.begin[0] >= b.end[0] || b.begin[1] >= b.end[1] || b.begin[2] >= b.end[2];

export const voxelCount = (g: Grid): number => g.size[0] * g.size[1] * g.size[2];

export const boxCount = (b: Box): number =>
    isEmpty(b) ? 0 : sub(b.end, b.begin).reduce((product, n) => product * n, 1);

const scaled = (v: Vec3, s: Vec3): Vec3 => [v[0] * s[0], v[1] * s[1], v[2] * s[2]];
const divided = (v: Vec3, s: Vec3): Vec3 => [v[0] / s[0], v[1] / s[1], v[2] / s[2]];

export const worldFromVoxel = (g: Grid, ijk: Vec3): Vec3 =>
    add(g.origin, apply(g.direction, scaled(ijk, g.spacing)));
/// Converts a difference of world positions to voxel units.
export const voxelVector = (g: Grid, v: Vec3): Vec3 =>
    divided(applyTransposed(g.direction, v), g.spacing);
export const voxelFromWorld = (g: Grid, x: Vec3): Vec3 => voxelVector(g, sub(x, g.origin));

/// Whether a position lies between the centres of the outermost voxels.
export const isWithin = (g: Grid, x: Vec3): boolean =>
    voxelFromWorld(g, x).every((n, a) => n >= 0 && n <= g.size[a]! - 1);

/// Bounding box of the volume, to the outer faces of the outermost voxels [mm, LPS].
export function worldBounds(g: Grid): { low: Vec3; high: Vec3 } {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let corner = 0; corner < 8; ++corner) {
        const ijk = g.size.map((n, a) => ((corner >> a) & 1 ? n - 0.5 : -0.5));
        worldFromVoxel(g, ijk as unknown as Vec3).forEach((x, a) => {
            low[a] = Math.min(low[a]!, x);
            high[a] = Math.max(high[a]!, x);
        });
    }
    return { low: low as unknown as Vec3, high: high as unknown as Vec3 };
}

/// 4×4 matrix from world points to voxel indices, in column-major order.
export function voxelFromWorldMatrix(g: Grid): number[] {
    const o = voxelFromWorld(g, [0, 0, 0]);
    const x = sub(voxelFromWorld(g, [1, 0, 0]), o);
    const y = sub(voxelFromWorld(g, [0, 1, 0]), o);
    const z = sub(voxelFromWorld(g, [0, 0, 1]), o);
    return [...x, 0, ...y, 0, ...z, 0, ...o, 1];
}

/// Patient coordinate systems for display: files hold LPS, 3D Slicer shows RAS.
export type Space = 'LPS' | 'RAS';
export const shown = (x: Vec3, space: Space): Vec3 =>
    space === 'LPS' ? x : [0 - x[0], 0 - x[1], x[2]];
