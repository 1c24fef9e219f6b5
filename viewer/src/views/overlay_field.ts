// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Values of an overlay on the scan's grid. It exists only while an overlay is shown.

import type { Box, Grid } from '../maths/grid.ts';
import { floatOfHalf, halfOfFloat } from '../maths/half.ts';
import type { Vec3 } from '../maths/vec.ts';
import { kKinds, type ShownKind } from '../state/overlay_kinds.ts';
import { HalfField } from './half_field.ts';

const kEdge = 8; // of the blocks whose extremes are cached [voxels]

export class OverlayField extends HalfField {
    /// Largest departure from rest in each block.
    private readonly extremes: Float32Array;
    private readonly blocks: Vec3;

    constructor(
        readonly kind: ShownKind,
        readonly grid: Grid,
    ) {
        super('overlay', grid.size, 1);
        const { rest } = kKinds[kind];
        if (rest) this.halves.fill(halfOfFloat(rest));
        this.blocks = grid.size.map((n) => Math.ceil(n / kEdge)) as unknown as Vec3;
        this.extremes = new Float32Array(this.blocks[0] * this.blocks[1] * this.blocks[2]);
    }

    override patch(box: Box, values: Uint16Array): void {
        super.patch(box, values);
        this.updateExtremes(box);
    }

    /// Largest departure from rest anywhere.
    get extreme(): number {
        return this.extremes.reduce((most, x) => Math.max(most, x), 0);
    }

    /// Value of the nearest voxel; undefined outside of the scan.
    valueAt(ijk: Vec3): number | undefined {
        const at = ijk.map(Math.round);
        if (at.some((x, a) => x < 0 || x >= this.grid.size[a]!)) return undefined;
        const [nx, ny] = this.grid.size;
        return floatOfHalf[this.halves[at[0]! + nx * (at[1]! + ny * at[2]!)]!];
    }

    private updateExtremes(box: Box): void {
        const { rest } = kKinds[this.kind];
        const [nx, ny, nz] = this.grid.size;
        const [bx, by] = this.blocks;
        const first = box.begin.map((b) => Math.floor(b / kEdge));
        const last = box.end.map((e) => Math.ceil(e / kEdge));
        for (let z = first[2]!; z < last[2]!; ++z)
            for (let y = first[1]!; y < last[1]!; ++y)
                for (let x = first[0]!; x < last[0]!; ++x) {
                    let most = 0;
                    const end = Math.min((x + 1) * kEdge, nx);
                    for (let k = z * kEdge; k < Math.min((z + 1) * kEdge, nz); ++k)
                        for (let j = y * kEdge; j < Math.min((y + 1) * kEdge, ny); ++j)
                            for (let i = x * kEdge; i < end; ++i) {
                                const value = floatOfHalf[this.halves[i + nx * (j + ny * k)]!]!;
                                most = Math.max(most, Math.abs(value - rest));
                            }
                    this.extremes[x + bx * (y + by * z)] = most;
                }
    }
}
