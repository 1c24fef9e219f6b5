// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Free flight through a lumen, without segmentation or centreline. The tip is a sphere; collision
// is tested at its centre and at 26 points of its surface against the threshold, in the mirror of
// the deformed volume, so that a wall that was pushed away makes room.

import { voxelFromWorld } from './grid.ts';
import { firstHit, inTissue, type Surface, wallNormal } from './rays.ts';
import { along, dot, mul, norm, normalized, sub, type Vec3 } from './vec.ts';
import type { VolumeData } from './volume.ts';

/// Directions to the corners, edges and faces of a cube.
const kDirections: readonly Vec3[] = (() => {
    const all: Vec3[] = [];
    for (let i = 0; i < 27; ++i) {
        const v: Vec3 = [(i % 3) - 1, (Math.floor(i / 3) % 3) - 1, Math.floor(i / 9) - 1];
        if (norm(v) > 0) all.push(normalized(v));
    }
    return all;
})();

const valueAt = (volume: VolumeData, place: Vec3): number =>
    volume.sample(voxelFromWorld(volume.grid, place));

/// Share of the sphere's points in tissue, 0…1, plus 2 for its centre; and the sum of the wall's
/// normals at these points.
export function contact(
    volume: VolumeData,
    place: Vec3,
    radius: number,
    surface: Surface,
): { share: number; out: Vec3 } {
    let touching = 0;
    let out: Vec3 = [0, 0, 0];
    for (const direction of kDirections) {
        const point = along(place, radius, direction);
        if (!inTissue(valueAt(volume, point), surface)) continue;
        ++touching;
        out = along(out, 1, wallNormal(volume, point, direction, surface));
    }
    const centre = inTissue(valueAt(volume, place), surface) ? 2 : 0;
    return { share: centre + touching / kDirections.length, out };
}

const kSight = 80; // longest way that counts [mm]
const kWayStep = 0.25; // between two samples of a motion [voxels]

/// Tests whether the tip's centre enters tissue during a motion. The contact of the sphere does not
/// show that: a thick tip touches a thin wall as much on one side as on the other.
export function meetsWall(volume: VolumeData, from: Vec3, to: Vec3, surface: Surface): boolean {
    const way = sub(to, from);
    const count = Math.ceil(norm(way) / (kWayStep * Math.min(...volume.grid.spacing)));
    let inside = inTissue(valueAt(volume, from), surface); // after a change of the threshold
    for (let n = 1; n <= count; ++n) {
        const now = inTissue(valueAt(volume, along(from, n / count, way)), surface);
        if (now && !inside) return true;
        inside = now;
    }
    return false;
}

/// End point of a motion of the tip: it stops at walls, and slides along them. A tip that is in
/// tissue already (after a change of the threshold) moves out of it, but not deeper.
export function flown(
    volume: VolumeData,
    from: Vec3,
    motion: Vec3,
    radius: number,
    surface: Surface,
): Vec3 {
    const spacing = Math.min(...volume.grid.spacing);
    const steps = Math.max(Math.ceil(norm(motion) / Math.min(0.5 * radius, spacing)), 1);
    const step = mul(1 / steps, motion);
    let place = from;
    let here = contact(volume, place, radius, surface).share;
    for (let i = 0; i < steps; ++i) {
        const next = along(place, 1, step);
        const there = contact(volume, next, radius, surface);
        if (there.share <= here && !meetsWall(volume, place, next, surface)) {
            place = next;
            here = there.share;
            continue;
        }
        if (!(norm(there.out) > 1e-6)) break;
        const normal = normalized(there.out);
        const into = Math.min(dot(step, normal), 0);
        const aside = along(place, 1, along(step, -into, normal));
        const share = contact(volume, aside, radius, surface).share;
        if (share > here || meetsWall(volume, place, aside, surface)) break;
        place = aside;
        here = share;
    }
    return place;
}

/// Nearest point outside of tissue, moved on to where the tip has most room. @returns undefined if
/// there is none within reach [mm]
export function freePlace(
    volume: VolumeData,
    place: Vec3,
    radius: number,
    surface: Surface,
    reach: number,
): Vec3 | undefined {
    const isFree = (at: Vec3): boolean => !inTissue(valueAt(volume, at), surface);
    if (isFree(place)) return place;
    const step = 0.5 * Math.min(...volume.grid.spacing);
    for (let away = step; away <= reach; away += step)
        for (const direction of kDirections) {
            const edge = along(place, away, direction);
            if (!isFree(edge)) continue;
            // Go on by at most the tip's radius, while the share of the tip in tissue falls.
            let best = edge;
            let share = contact(volume, best, radius, surface).share;
            for (let on = step; on <= radius && share > 0; on += step) {
                const next = along(edge, on, direction);
                const there = contact(volume, next, radius, surface).share;
                if (there > share) break;
                best = next;
                share = there;
            }
            return best;
        }
    return undefined;
}

/// Tests whether a motion increases the sphere's contact with tissue, or takes its centre into a
/// wall.
export const wouldTouch = (
    volume: VolumeData,
    from: Vec3,
    to: Vec3,
    radius: number,
    surface: Surface,
): boolean =>
    contact(volume, to, radius, surface).share > contact(volume, from, radius, surface).share ||
    meetsWall(volume, from, to, surface);

/// Distance from a point to the nearest wall, at most reach [mm].
export function clearance(
    volume: VolumeData,
    place: Vec3,
    surface: Surface,
    reach: number,
): number {
    let nearest = reach;
    for (const direction of kDirections) {
        const hit = firstHit(volume, place, direction, surface, nearest);
        if (hit) nearest = Math.min(nearest, hit.distance);
    }
    return nearest;
}

/// Direction in which a lumen goes on from a place: that of the longest way to a wall, where
/// directions near the present one count more.
export function alongLumen(
    volume: VolumeData,
    place: Vec3,
    present: Vec3,
    surface: Surface,
): Vec3 {
    let best = present;
    let most = 0;
    for (const direction of kDirections) {
        const room = firstHit(volume, place, direction, surface, kSight)?.distance ?? kSight;
        const worth = room * (1.5 + dot(direction, present));
        if (worth > most) [best, most] = [direction, worth];
    }
    return best;
}

/// Speed for a clearance around the tip [mm/s]. @param scale  of lengths: 1 in a body
export const speedFor = (room: number, scale = 1): number =>
    Math.min(Math.max(2.5 * room, 4 * scale), 80 * scale);
