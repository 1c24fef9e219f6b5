// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Inner surface of a vessel and the catheter in it (docs/developers/protocol.md, *Vessels*): the
// server sends the surface at rest once, then displacements of its nodes. Frames are validated
// before use.

import { floatOfHalf } from '../maths/half.ts';
import type { Vec3 } from '../maths/vec.ts';

export interface SurfaceFrame {
    kind: 'surface';
    volume: number;
    rest: Float32Array; ///< x, y, z of each node [mm, LPS]
    corners: Uint32Array; ///< of each triangle
}

export interface VesselFrame {
    kind: 'vessel';
    volume: number;
    radius: number; ///< of the catheter [mm]
    catheter: Float32Array; ///< x, y, z from the guide to the tip [mm, LPS]
    runs: Uint32Array; ///< runs of moved nodes: first node and count
    moved: Uint16Array; ///< displacements of these nodes, x, y, z, half floats [mm]
}

const kHeader = 32;
const kMaxNodes = 1 << 18;

export function decodeSurface(view: DataView, payload: number): SurfaceFrame {
    const nodes = payload >= 8 ? view.getUint32(kHeader, true) : 0;
    const cells = payload >= 8 ? view.getUint32(kHeader + 4, true) : 0;
    if (nodes > kMaxNodes || payload !== 8 + 12 * (nodes + cells))
        throw new Error(`surface: ${payload} bytes for ${nodes} nodes and ${cells} triangles`);
    const buffer = view.buffer as ArrayBuffer;
    const corners = new Uint32Array(buffer, kHeader + 8 + 12 * nodes, 3 * cells);
    if (corners.some((n) => n >= nodes))
        throw new Error(`surface: a corner beyond its ${nodes} nodes`);
    return {
        kind: 'surface',
        volume: view.getUint32(12, true),
        rest: new Float32Array(buffer, kHeader + 8, 3 * nodes),
        corners,
    };
}

export function decodeVessel(view: DataView, payload: number): VesselFrame {
    const points = payload >= 12 ? view.getUint32(kHeader + 4, true) : 0;
    const count = payload >= 12 ? view.getUint32(kHeader + 8, true) : 0;
    const before = 12 + 12 * points + 8 * count;
    if (points > kMaxNodes || count > kMaxNodes || payload < before)
        throw new Error(`vessel: ${payload} bytes for ${points} points and ${count} runs`);
    const buffer = view.buffer as ArrayBuffer;
    const runs = new Uint32Array(buffer, kHeader + 12 + 12 * points, 2 * count);
    const nodes = runs.reduce((sum, n, i) => sum + (i % 2 ? n : 0), 0);
    if (payload !== before + 6 * nodes)
        throw new Error(`vessel: ${payload} bytes for ${nodes} nodes that have moved`);
    return {
        kind: 'vessel',
        volume: view.getUint32(12, true),
        radius: view.getFloat32(kHeader, true),
        catheter: new Float32Array(buffer, kHeader + 12, 3 * points),
        runs,
        moved: new Uint16Array(buffer, kHeader + before, 3 * nodes),
    };
}

export class Vessel {
    readonly places: Float32Array;
    readonly moved: Float32Array; ///< length of each node's displacement [mm]
    catheter: Vec3[] = [];
    radius = 1;

    constructor(
        readonly rest: Float32Array,
        readonly corners: Uint32Array,
    ) {
        this.places = rest.slice();
        this.moved = new Float32Array(rest.length / 3);
    }

    take(frame: VesselFrame): void {
        const { runs, moved } = frame;
        for (let r = 0; r < runs.length; r += 2)
            if (runs[r]! + runs[r + 1]! > this.moved.length)
                throw new Error(`vessel: a run beyond its ${this.moved.length} nodes`);
        let at = 0;
        for (let r = 0; r < runs.length; r += 2)
            for (let n = runs[r]!; n < runs[r]! + runs[r + 1]!; ++n) {
                let square = 0;
                for (let a = 0; a < 3; ++a) {
                    const by = floatOfHalf[moved[at++]!]!;
                    this.places[3 * n + a] = this.rest[3 * n + a]! + by;
                    square += by * by;
                }
                this.moved[n] = Math.sqrt(square);
            }
        this.radius = frame.radius;
        this.catheter = Array.from({ length: frame.catheter.length / 3 }, (_, i) => [
            frame.catheter[3 * i]!,
            frame.catheter[3 * i + 1]!,
            frame.catheter[3 * i + 2]!,
        ]);
    }
}
