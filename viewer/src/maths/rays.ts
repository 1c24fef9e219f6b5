// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// First-hit rays through the mirror of the volume, for picking and collision: the same traversal as
// in the shader (shaders/surface.glsl), the same definition of a hit as in the C++ RayCaster.
// Rising: from below the threshold to at or above it; falling: the reverse. A ray that starts in
// tissue hits the next wall after it has left the tissue. There is nothing beyond the outermost
// voxel centres.

import { voxelFromWorld, voxelVector } from './grid.ts';
import { along, cross, dot, mul, norm, normalized, type Vec3 } from './vec.ts';
import { kBrick, type VolumeData } from './volume.ts';

export interface Surface {
    readonly iso: number; ///< [HU]
    readonly rising: boolean; ///< the lumen is filled with air; false: with contrast medium
}

export interface Hit {
    readonly distance: number; ///< [mm]
    readonly point: Vec3; ///< [mm, LPS]
    readonly normal: Vec3; ///< unit, towards the ray's origin
}

const kStep = 0.5; // [voxels]; thinner walls may be missed

export const inTissue = (value: number, s: Surface): boolean => value >= s.iso === s.rising;

export function firstHit(
    volume: VolumeData,
    origin: Vec3,
    direction: Vec3,
    surface: Surface,
    reach = Infinity,
): Hit | undefined {
    const unit = normalized(direction);
    const o = voxelFromWorld(volume.grid, origin);
    const d = voxelVector(volume.grid, unit);
    const distance = hitDistance(volume, o, d, surface, reach);
    if (distance === undefined) return undefined;
    const point = along(origin, distance, unit);
    return { distance, point, normal: wallNormal(volume, point, unit, surface) };
}

/// Unit normal of the wall at a point, towards the lumen and never along the ray.
export function wallNormal(volume: VolumeData, point: Vec3, ray: Vec3, surface: Surface): Vec3 {
    const g = volume.grid;
    const slope = volume.gradient(voxelFromWorld(g, point)).map((s, a) => s / g.spacing[a]!);
    const world = [0, 1, 2].map(
        (a) =>
            slope[0]! * g.direction[0][a]! +
            slope[1]! * g.direction[1][a]! +
            slope[2]! * g.direction[2][a]!,
    ) as unknown as Vec3;
    if (!(norm(world) > 1e-9)) return mul(-1, ray);
    const n = mul((surface.rising ? -1 : 1) / norm(world), world);
    const facing = dot(n, ray);
    return facing > 0 ? normalized(along(n, -facing, ray)) : n;
}

/// @param d  voxels per millimetre
function hitDistance(
    volume: VolumeData,
    o: Vec3,
    d: Vec3,
    surface: Surface,
    reach: number,
): number | undefined {
    const last = volume.grid.size.map((n) => n - 1);
    let t = 0;
    let exit = reach;
    for (let a = 0; a < 3; ++a) {
        if (d[a] === 0) {
            if (o[a]! < 0 || o[a]! > last[a]!) return undefined;
            continue;
        }
        const t0 = (0 - o[a]!) / d[a]!;
        const t1 = (last[a]! - o[a]!) / d[a]!;
        t = Math.max(t, Math.min(t0, t1));
        exit = Math.min(exit, Math.max(t0, t1));
    }
    if (!(t < exit)) return undefined;
    const at = (s: number): number => volume.sample(along(o, s, d));
    const step = kStep / norm(d);
    let above = at(t) >= surface.iso;
    while (t < exit) {
        const [end, low, high] = brickAhead(volume, o, d, t, exit);
        if (low >= surface.iso || high < surface.iso) {
            const now = low >= surface.iso;
            if (now !== above && now === surface.rising) return t;
            above = now;
            t = end;
            continue;
        }
        while (t < end) {
            const next = Math.min(t + step, end);
            const now = at(next) >= surface.iso;
            if (now !== above && now === surface.rising)
                return crossing((s) => at(s) - surface.iso, t, next);
            above = now;
            t = next;
        }
    }
    return undefined;
}

/// End of the ray in its current brick, and the range of values in that brick.
function brickAhead(
    volume: VolumeData,
    o: Vec3,
    d: Vec3,
    t: number,
    exit: number,
): [number, number, number] {
    const nudge = 1e-4 / norm(d); // a point just ahead decides between two bricks
    const p = along(o, t + nudge, d);
    let end = exit;
    let index = 0;
    for (let a = 2; a >= 0; --a) {
        const b = Math.min(Math.max(Math.floor(p[a]! / kBrick), 0), volume.brickSize[a]! - 1);
        index = index * volume.brickSize[a]! + b;
        if (d[a] !== 0) end = Math.min(end, ((b + (d[a]! > 0 ? 1 : 0)) * kBrick - o[a]!) / d[a]!);
    }
    end = Math.min(Math.max(end, t + nudge), exit);
    return [end, volume.brickRange[2 * index]!, volume.brickRange[2 * index + 1]!];
}

/// Root of f between a and b, by the Illinois variant of regula falsi. @pre f changes sign
function crossing(f: (t: number) => number, a: number, b: number): number {
    let fa = f(a);
    let fb = f(b);
    for (let i = 0; i < 20 && b - a > 1e-7; ++i) {
        const s = fa === fb ? 0.5 * (a + b) : (a * fb - b * fa) / (fb - fa);
        const fs = f(s);
        if (fs === 0) return s;
        if (fs >= 0 === fb >= 0) {
            b = s;
            fb = fs;
            fa *= 0.5;
        } else {
            a = s;
            fa = fs;
            fb *= 0.5;
        }
    }
    return 0.5 * (a + b);
}

/// Conventional up vector of radiology that is not parallel to look.
export const naturalUp = (look: Vec3): Vec3 =>
    Math.abs(look[2]) < 0.9 * norm(look) ? [0, 0, 1] : [0, -1, 0];

export interface Camera {
    readonly eye: Vec3; ///< [mm, LPS]
    readonly look: Vec3; ///< unit
    readonly up: Vec3; ///< approximate, not parallel to look
}

/// Right, up and forward of a camera, perpendicular unit vectors.
export function frameOf(camera: Camera): { right: Vec3; up: Vec3; forward: Vec3 } {
    const forward = normalized(camera.look);
    let right = cross(forward, camera.up);
    if (!(norm(right) > 1e-6)) right = cross(forward, naturalUp(forward));
    right = normalized(right);
    return { right, up: cross(right, forward), forward };
}

/// Direction of the ray through a point of the picture. u, v: from the centre, to the right and up,
/// ±1 at the middle of the upper and lower edge. r_ray = r·(1 + barrel·r²).
export function rayThrough(
    camera: Camera,
    fieldOfView: number,
    barrel: number,
    u: number,
    v: number,
): Vec3 {
    const { right, up, forward } = frameOf(camera);
    const scale = Math.tan((fieldOfView * Math.PI) / 360) * (1 + barrel * (u * u + v * v));
    return normalized(along(along(forward, scale * u, right), scale * v, up));
}
