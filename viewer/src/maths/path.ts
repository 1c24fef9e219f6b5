// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Path through a lumen: a polyline, as in 3D Slicer's markups (.mrk.json), flown at constant speed.
// The endoscope looks at a point some millimetres ahead, so that it doesn't jerk at each vertex.

import { naturalUp } from './rays.ts';
import { along, dot, norm, normalized, sub, type Vec3 } from './vec.ts';

const kLookAhead = 12; // [mm]

export class Path {
    /// Arc length from the first point to each [mm].
    private readonly ways: readonly number[];

    /// @param radii  distance of each point to the wall [mm]; empty if unknown
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

    /// Arc length from the first point to another [mm].
    wayOf(point: number): number {
        return this.ways[point]!;
    }

    /// Point at an arc length [mm], clamped to the path.
    at(way: number): Vec3 {
        const { points, ways } = this;
        const w = Math.min(Math.max(way, 0), this.length);
        let i = ways.findIndex((end) => end >= w);
        i = Math.max(i, 1);
        const [a, b] = [points[i - 1]!, points[i]!];
        const share = (w - ways[i - 1]!) / Math.max(ways[i]! - ways[i - 1]!, 1e-9);
        return along(a, share, sub(b, a));
    }

    /// Camera at an arc length [mm], with an up vector as near as possible to the given one.
    /// @param scale  of lengths: 1 in a body
    camera(way: number, up: Vec3, scale = 1): { eye: Vec3; look: Vec3; up: Vec3 } {
        const eye = this.at(way);
        const ahead = scale * kLookAhead;
        const end = this.length - ahead;
        // Near the end the direction stays as it is.
        const from = Math.min(way, Math.max(end, 0));
        const look = normalized(sub(this.at(from + ahead), this.at(from)));
        const across = along(up, -dot(up, look), look);
        return { eye, look, up: norm(across) > 0.05 ? normalized(across) : naturalUp(look) };
    }

    /// Arc length of the path's point that is nearest to a position [mm].
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

/// Writes a curve for 3D Slicer.
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

/// Parses a markups file. @throws an Error that names the missing field
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
    // Old files of Slicer have 0 for RAS and 1 for LPS.
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
