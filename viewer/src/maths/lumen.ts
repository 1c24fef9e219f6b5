// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cross-section of a lumen: the part of a plane that is connected to a point of the lumen, in the
// mirror of the deformed scan. The plane is sampled on a square grid and filled from the point. The
// border is found by marching squares with linear interpolation.
//
//     + wall      the border crosses the sides of cells between a sample in the lumen (o)
//   o-x-+         and one in the wall (+); its pieces (x to x) give area and widths
//   |/  |
//   x---+

import { voxelFromWorld } from './grid.ts';
import { inTissue, naturalUp, type Surface } from './rays.ts';
import { along, cross, norm, normalized, type Vec3 } from './vec.ts';
import type { VolumeData } from './volume.ts';

export interface CrossSection {
    readonly area: number; ///< [mm²]
    readonly equivalent: number; ///< diameter of the circle of the same area [mm]
    readonly inscribed: number; ///< diameter of the largest circle in it [mm]
    readonly narrow: number; ///< smallest width between two parallel lines [mm]
    readonly wide: number; ///< largest one
    readonly border: readonly (readonly [Vec3, Vec3])[]; ///< pieces, in no order [mm, LPS]
}

/// Sections that reach farther from the point are open: there is a leak, or no lumen at all.
export const kLumenReach = 40; // in a body [mm]
const kDirections = 90; // for the widths

type Spot = readonly [number, number]; // in the plane [mm]

/// Cross-section at a point, perpendicular to a direction. @returns undefined if the point is in
/// tissue or outside of the scan; 'open' if the section reaches the scan's border or kLumenReach
/// @param scale  of lengths: 1 in a body
export function crossSection(
    volume: VolumeData,
    point: Vec3,
    direction: Vec3,
    surface: Surface,
    scale = 1,
): CrossSection | 'open' | undefined {
    const { grid } = volume;
    const finest = 0.5 * Math.min(...grid.spacing);
    const step = Math.min(Math.max(finest, 0.2 * scale), scale);
    const half = Math.ceil((kLumenReach * scale) / step);
    const side = 2 * half + 1;
    const normal = normalized(direction);
    const right = normalized(cross(normal, naturalUp(normal)));
    const up = cross(right, normal);
    const worldOf = ([u, v]: Spot): Vec3 => along(along(point, u, right), v, up);
    const last = grid.size.map((n) => n - 1);
    /// Values above zero are in the lumen; NaN: outside of the scan.
    const values = new Float32Array(side * side);
    const known = new Uint8Array(side * side);
    const valueAt = (i: number, j: number): number => {
        const at = i + side * j;
        if (known[at]) return values[at]!;
        known[at] = 1;
        const p = voxelFromWorld(grid, worldOf([(i - half) * step, (j - half) * step]));
        const inside = p.every((x, a) => x >= 0 && x <= last[a]!);
        const value = volume.sample(p) - surface.iso;
        // A value on the threshold is tissue.
        const lumen = !inTissue(value + surface.iso, surface);
        const depth = Math.max(Math.abs(value), 1e-6);
        return (values[at] = inside ? (lumen ? depth : -depth) : NaN);
    };
    if (!(valueAt(half, half) > 0)) return undefined;
    const filled = new Uint8Array(side * side);
    const queue = [half + side * half];
    filled[queue[0]!] = 1;
    for (let n = 0; n < queue.length; ++n) {
        const i = queue[n]! % side;
        const j = Math.floor(queue[n]! / side);
        if (i === 0 || j === 0 || i === side - 1 || j === side - 1) return 'open';
        for (const [di, dj] of [
            [1, 0],
            [-1, 0],
            [0, 1],
            [0, -1],
        ] as const) {
            const value = valueAt(i + di, j + dj);
            if (Number.isNaN(value)) return 'open';
            const at = i + di + side * (j + dj);
            if (value <= 0 || filled[at]) continue;
            filled[at] = 1;
            queue.push(at);
        }
    }
    const own = (i: number, j: number): number => {
        // Lumen that is not connected belongs to another section.
        const value = valueAt(i, j);
        return value > 0 && !filled[i + side * j] ? -value : value;
    };
    const spotOf = (i: number, j: number): Spot => [(i - half) * step, (j - half) * step];
    const cells = new Set<number>();
    for (const at of queue) for (const back of [0, 1, side, side + 1]) cells.add(at - back);
    let area = 0;
    const pieces: [Spot, Spot][] = [];
    for (const at of cells) {
        const i = at % side;
        const j = Math.floor(at / side);
        area += cellArea(i, j, own, spotOf, pieces);
    }
    const ends = pieces.map(([a]) => a);
    const [narrow, wide] = widths(ends);
    return {
        area,
        equivalent: 2 * Math.sqrt(area / Math.PI),
        inscribed:
            2 *
            largestRadius(
                queue.map((at) => spotOf(at % side, Math.floor(at / side))),
                pieces,
                step,
                scale,
            ),
        narrow,
        wide,
        border: pieces.map(([a, b]) => [worldOf(a), worldOf(b)] as const),
    };
}

/// Area of the lumen in a cell of the grid; adds its pieces of the border.
function cellArea(
    i: number,
    j: number,
    valueAt: (i: number, j: number) => number,
    spotOf: (i: number, j: number) => Spot,
    pieces: [Spot, Spot][],
): number {
    const corners = [
        [i, j],
        [i + 1, j],
        [i + 1, j + 1],
        [i, j + 1],
    ] as const;
    const values = corners.map(([x, y]) => valueAt(x, y));
    const inside = values.map((v) => v > 0);
    // Two opposite corners in the lumen: it is one or two parts, by the sign of the middle.
    const two = inside[0] === inside[2] && inside[1] === inside[3] && inside[0] !== inside[1];
    const joined = two && values.reduce((sum, v) => sum + v, 0) > 0;
    const polygons: Spot[][] = [[]];
    const borders: Spot[] = [];
    corners.forEach(([x, y], c) => {
        const next = (c + 1) % 4;
        const polygon = polygons[polygons.length - 1]!;
        if (inside[c]) polygon.push(spotOf(x, y));
        if (inside[c] === inside[next]) return;
        const [a, b] = [spotOf(x, y), spotOf(...corners[next]!)];
        const share = values[c]! / (values[c]! - values[next]!);
        const spot: Spot = [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
        polygon.push(spot);
        borders.push(spot);
        if (two && !joined && inside[c]) polygons.push([]);
    });
    // Parts that begin and end in the same corner.
    if (polygons.length > 1 && inside[0]) polygons[0] = [...polygons.pop()!, ...polygons[0]!];
    if (borders.length === 2) pieces.push([borders[0]!, borders[1]!]);
    if (borders.length === 4) {
        const turn = inside[0] === joined ? 0 : 1;
        pieces.push(
            [borders[turn]!, borders[turn + 1]!],
            [borders[turn + 2]!, borders[(turn + 3) % 4]!],
        );
    }
    return polygons.reduce((sum, polygon) => sum + polygonArea(polygon), 0);
}

const polygonArea = (spots: readonly Spot[]): number =>
    0.5 *
    Math.abs(
        spots.reduce((sum, [x, y], n) => {
            const [u, v] = spots[(n + 1) % spots.length]!;
            return sum + x * v - u * y;
        }, 0),
    );

/// Smallest and largest width of a set of points.
function widths(spots: readonly Spot[]): [number, number] {
    let narrow = Infinity;
    let wide = 0;
    for (let n = 0; n < kDirections; ++n) {
        const angle = (n * Math.PI) / kDirections;
        const [c, s] = [Math.cos(angle), Math.sin(angle)];
        let low = Infinity;
        let high = -Infinity;
        for (const [x, y] of spots) {
            const at = c * x + s * y;
            if (at < low) low = at;
            if (at > high) high = at;
        }
        narrow = Math.min(narrow, high - low);
        wide = Math.max(wide, high - low);
    }
    return [narrow, wide];
}

/// Radius of the largest circle: the largest distance to the border among the samples, refined
/// around the best one.
function largestRadius(
    samples: readonly Spot[],
    pieces: readonly (readonly [Spot, Spot])[],
    step: number,
    scale: number,
): number {
    const distance = ([x, y]: Spot, least: number): number => {
        let nearest = Infinity;
        for (const [a, b] of pieces) {
            const [u, v] = [b[0] - a[0], b[1] - a[1]];
            const t = ((x - a[0]) * u + (y - a[1]) * v) / (u * u + v * v || 1);
            const s = Math.min(Math.max(t, 0), 1);
            const d = Math.hypot(x - a[0] - s * u, y - a[1] - s * v);
            if (d < nearest) nearest = d;
            if (nearest <= least) return nearest; // no better than the best one
        }
        return nearest;
    };
    let best = 0;
    let place = samples[0]!;
    const take = (spot: Spot): void => {
        const d = distance(spot, best);
        if (d <= best) return;
        best = d;
        place = spot;
    };
    for (const spot of samples) take(spot);
    for (let size = step / 2; size > 0.01 * scale; size /= 2)
        for (let turns = 0; turns < 4; ++turns) {
            const [x, y] = place;
            for (const [dx, dy] of [
                [1, 0],
                [-1, 0],
                [0, 1],
                [0, -1],
            ] as const)
                take([x + size * dx, y + size * dy]);
            if (place[0] === x && place[1] === y) break;
        }
    return best;
}

/// Sections at points along a line of points, perpendicular to it.
export function* sectionsAlong(
    volume: VolumeData,
    points: readonly Vec3[],
    surface: Surface,
    scale = 1,
): Generator<CrossSection | 'open' | undefined> {
    for (const [n, point] of points.entries()) {
        const before = points[Math.max(n - 1, 0)]!;
        const after = points[Math.min(n + 1, points.length - 1)]!;
        const way: Vec3 = [after[0] - before[0], after[1] - before[1], after[2] - before[2]];
        yield norm(way) > 0 ? crossSection(volume, point, way, surface, scale) : undefined;
    }
}
