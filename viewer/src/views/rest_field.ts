// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rest field: positions of the tissue at rest, and raw tissue, at every 4th voxel of the deformed
// scan. It exists only while the style real needs it.

import * as THREE from 'three';
import type { Box, Grid } from '../maths/grid.ts';
import { floatOfHalf } from '../maths/half.ts';
import type { Vec3 } from '../maths/vec.ts';
import { HalfField } from './half_field.ts';

export const kRestStep = 4; // from one node to the next [voxels]
const kHalves = 4; // per node: x, y, z of the offset, raw

/// Position at rest = position − offset [mm, LPS]; raw: 0…1, 1 where tissue was carved or cut.
export interface RestSample {
    readonly offset: Vec3;
    readonly raw: number;
}

/// Nodes along each axis.
export const restCounts = (grid: Grid): Vec3 =>
    grid.size.map((n) => Math.ceil((n - 1) / kRestStep) + 1) as unknown as Vec3;

export class RestField extends HalfField {
    hasRaw = false; ///< raw tissue has been seen

    /// Creates a field at rest.
    constructor(readonly grid: Grid) {
        super('rest', restCounts(grid), kHalves);
    }

    override patch(box: Box, values: Uint16Array): void {
        super.patch(box, values);
        for (let n = kHalves - 1; n < values.length && !this.hasRaw; n += kHalves)
            this.hasRaw = values[n]! !== 0;
    }

    /// Trilinear sample, as in the shaders. @param ijk  [voxels]
    at(ijk: Vec3): RestSample {
        const low: number[] = [];
        const t: number[] = [];
        ijk.forEach((p, a) => {
            const last = this.counts[a]! - 1;
            const x = Math.min(Math.max(p / kRestStep, 0), last);
            low.push(Math.min(Math.floor(x), Math.max(last - 1, 0)));
            t.push(x - low[a]!);
        });
        const sum = [0, 0, 0, 0];
        for (let corner = 0; corner < 8; ++corner) {
            let weight = 1;
            const node = low.map((n, a) => {
                const high = (corner >> a) & 1;
                weight *= high ? t[a]! : 1 - t[a]!;
                return Math.min(n + high, this.counts[a]! - 1);
            });
            if (weight === 0) continue;
            const [nx, ny] = this.counts;
            const at = kHalves * (node[0]! + nx * (node[1]! + ny * node[2]!));
            for (let c = 0; c < kHalves; ++c)
                sum[c]! += weight * floatOfHalf[this.halves[at + c]!]!;
        }
        return { offset: [sum[0]!, sum[1]!, sum[2]!], raw: sum[3]! };
    }
}

/// Uniforms of shaders/rest.glsl.
export function restUniforms(field: RestField | undefined): Record<string, unknown> {
    return {
        restOn: field !== undefined,
        restField: field?.texture ?? null,
        restCount: new THREE.Vector3(...(field?.counts ?? [1, 1, 1])),
    };
}
