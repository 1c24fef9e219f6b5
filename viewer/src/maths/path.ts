// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A way through a lumen, as 3D Slicer's markups hold it (.mrk.json): points, joined by lines, flown
// at an even speed. The endoscope looks to a place some millimetres ahead, so that it doesn't jerk
// at each point.

import { naturalUp } from './rays.ts';
import { along, dot, norm, normalized, sub, type Vec3 } from './vec.ts';

const kLookAhead = 12; // [mm]

export class Path {
    /// Way from the first point to each [mm].
    private readonly ways: readonly number[];

    /// @param radii  distance of each point to the wall [mm]; none where that isn't known
    constructor(
        readonly points: readonly Vec3[],
        readonly radii: readonly number[] = [],
    ) {
        let way = 0;
        this.ways = points.map((p, i) => (way += i > 0 ? norm(sub(p, points[i - 1]!)) : 0));
    }

    get length(): number {
        return this.ways[this.ways.length - 1]!;
    }

    /// The place after some way; the ends go on for ever.
    at(way: number): Vec3 {
        const { points, ways } = this;
        const w = Math.min(Math.max(way, 0), this.length);
        let i = ways.findIndex((end) => end >= w);
        i = Math.max(i, 1);
        const [a, b] = [points[i - 1]!, points[i]!];
        const share = (w - ways[i - 1]!) / Math.max(ways[i]! - ways[i - 1]!, 1e-9);
        return along(a, share, sub(b, a));
    }

    /// Eye and direction after some way, up as far as can be.
    camera(way: number, up: Vec3): { eye: Vec3; look: Vec3; up: Vec3 } {
        const eye = this.at(way);
        const end = this.length - kLookAhead;
        // At the end it goes on looking where it looked.
        const from = Math.min(way, Math.max(end, 0));
        const look = normalized(sub(this.at(from + kLookAhead), this.at(from)));
        const across = along(up, -dot(up, look), look);
        return { eye, look, up: norm(across) > 0.05 ? normalized(across) : naturalUp(look) };
    }

    /// The way to the point of the path that is nearest to a place.
    nearest(place: Vec3): number {
        let best = 0;
        let least = Infinity;
        for (let i = 1; i < this.points.length; ++i) {
            const [a, b] = [this.points[i - 1]!, this.points[i]!];
            const v = sub(b, a);
            const share = Math.min(Math.max(dot(sub(place, a), v) / (dot(v, v) || 1), 0), 1);
            const off = norm(sub(along(a, share, v), place));
            if (off < least) {
                least = off;
                best = this.ways[i - 1]! + share * norm(v);
            }
        }
        return best;
    }
}

/// A curve for 3D Slicer.
export function writePath(path: Path): string {
    const controlPoints = path.points.map((position, i) => ({
        id: String(i + 1),
        label: `way-${i + 1}`,
        description: path.radii[i] === undefined ? '' : `radius ${path.radii[i].toFixed(2)} mm`,
        position,
        selected: true,
        locked: false,
        visibility: true,
        positionStatus: 'defined',
    }));
    const schema =
        'https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/' +
        'Resources/Schema/markups-schema-v1.0.3.json#';
    const curve = { type: 'Curve', coordinateSystem: 'LPS', coordinateUnits: 'mm', controlPoints };
    return JSON.stringify({ '@schema': schema, markups: [curve] }, null, 1) + '\n';
}

/// Reads a markups file; throws an Error that says what is missing.
export function readPath(text: string, name: string): Path {
    let file: {
        markups?: {
            coordinateSystem?: string | number;
            controlPoints?: { position?: unknown }[];
        }[];
    };
    try {
        file = JSON.parse(text);
    } catch {
        throw new Error(`${name}: expected a markups file (.mrk.json), found no JSON`);
    }
    const markup = file?.markups?.[0];
    if (!Array.isArray(markup?.controlPoints))
        throw new Error(`${name}: expected markups[0].controlPoints`);
    // Slicer's old files say 0 for RAS and 1 for LPS.
    const system = markup.coordinateSystem ?? 'LPS';
    const ras = system === 'RAS' || system === 0 || system === '0';
    const points = markup.controlPoints.map(({ position }, i): Vec3 => {
        const p = position as number[];
        if (!Array.isArray(p) || p.length !== 3 || !p.every(Number.isFinite))
            throw new Error(`${name}: controlPoints[${i}].position: expected three numbers`);
        return ras ? [-p[0]!, -p[1]!, p[2]!] : [p[0]!, p[1]!, p[2]!];
    });
    const different = points.filter((p, i) => i === 0 || norm(sub(p, points[i - 1]!)) > 1e-6);
    if (different.length < 2)
        throw new Error(`${name}: expected two points or more, found ${different.length}`);
    return new Path(different);
}
