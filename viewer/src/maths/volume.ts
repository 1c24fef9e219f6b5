// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mirror of the server's deformed volume in half floats, patched by boxes as they arrive. Textures
// are uploaded from it (also after a lost graphics context); the value under the pointer, picking
// and collision are computed from it, so that nothing is read back from the graphics processor.
//
// Bricks of 4³ cells hold the minimum and maximum of their corners: rays skip bricks without the
// threshold.

import { type Box, type Grid, voxelCount, worldFromVoxel } from './grid.ts';
import { floatOfHalf, halfOfOrder, orderOfHalf } from './half.ts';
import type { Vec3 } from './vec.ts';

export const kBrick = 4; // cells along an edge

const clamp = (x: number, low: number, high: number): number => Math.min(Math.max(x, low), high);

/// Copies a box of values, i fastest, into the values of a whole grid.
export function writeBox(halves: Uint16Array, size: Vec3, box: Box, values: Uint16Array): void {
    const [nx, ny] = size;
    const width = box.end[0] - box.begin[0];
    let from = 0;
    for (let k = box.begin[2]; k < box.end[2]; ++k)
        for (let j = box.begin[1]; j < box.end[1]; ++j) {
            halves.set(values.subarray(from, from + width), box.begin[0] + nx * (j + ny * k));
            from += width;
        }
}

export class VolumeData {
    readonly grid: Grid;
    readonly halves: Uint16Array; ///< i fastest
    readonly brickSize: Vec3; ///< bricks along each axis
    readonly brickHalves: Uint16Array; ///< minimum and maximum of each brick, interleaved
    /// The same as floats.
    readonly brickRange: Float32Array;
    /// Number of patches so far.
    version = 0;
    /// While a scan is being loaded: voxels of each slice k that have arrived, and layers of bricks
    /// that are complete.
    private arriving: { readonly voxels: Uint32Array; layers: number } | undefined;

    /// @param isEmpty  the values are still to come, by fill() and at last finish()
    constructor(grid: Grid, halves: Uint16Array, isEmpty = false) {
        if (halves.length !== voxelCount(grid))
            throw new Error(`volume: ${halves.length} voxels, expected ${voxelCount(grid)}`);
        this.grid = grid;
        this.halves = halves;
        this.brickSize = grid.size.map((n) =>
            Math.max(Math.ceil((n - 1) / kBrick), 1),
        ) as unknown as Vec3;
        const count = this.brickSize[0] * this.brickSize[1] * this.brickSize[2];
        this.brickHalves = new Uint16Array(2 * count);
        this.brickRange = new Float32Array(2 * count);
        if (isEmpty) this.arriving = { voxels: new Uint32Array(grid.size[2]), layers: 0 };
        else this.computeLayers(0, this.brickSize[2]);
    }

    /// Writes a box of a scan that is being loaded. Layers of bricks are computed when all their
    /// slices are there, the others by finish(). @returns the box of bricks that were computed
    fill(box: Box, values: Uint16Array): Box {
        writeBox(this.halves, this.grid.size, box, values);
        ++this.version;
        const arriving = this.arriving!;
        const [nx, ny, nz] = this.grid.size;
        for (let k = box.begin[2]; k < box.end[2]; ++k)
            arriving.voxels[k]! += (box.end[0] - box.begin[0]) * (box.end[1] - box.begin[1]);
        const before = arriving.layers;
        const isThere = (k: number): boolean => k >= nz || arriving.voxels[k]! >= nx * ny;
        const isComplete = (layer: number): boolean => {
            for (let k = 0; k <= kBrick; ++k) if (!isThere(kBrick * layer + k)) return false;
            return true;
        };
        while (arriving.layers < this.brickSize[2] && isComplete(arriving.layers))
            ++arriving.layers;
        // Repeated data change layers that were complete before.
        return this.computeLayers(Math.min(this.bricksOf(box).begin[2], before), arriving.layers);
    }

    /// Computes the bricks that no call of fill() has. @returns their box
    finish(): Box {
        const done = this.arriving?.layers ?? 0;
        this.arriving = undefined;
        return this.computeLayers(done, this.brickSize[2]);
    }

    /// Writes a box of values, i fastest, and returns the box of bricks that changed.
    patch(box: Box, values: Uint16Array): Box {
        writeBox(this.halves, this.grid.size, box, values);
        ++this.version;
        return this.computeBricks(this.bricksOf(box));
    }

    /// Copies a box of voxels.
    copyOf({ begin, end }: Box): VolumeData {
        const { grid } = this;
        const size: Vec3 = [end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]];
        const halves = new Uint16Array(size[0] * size[1] * size[2]);
        let to = 0;
        for (let k = begin[2]; k < end[2]; ++k)
            for (let j = begin[1]; j < end[1]; ++j, to += size[0]) {
                const from = begin[0] + grid.size[0] * (j + grid.size[1] * k);
                halves.set(this.halves.subarray(from, from + size[0]), to);
            }
        return new VolumeData({ ...grid, size, origin: worldFromVoxel(grid, begin) }, halves);
    }

    /// Trilinear value at a continuous voxel index, constant beyond the outermost centres [HU].
    sample(p: Vec3): number {
        const [nx, ny, nz] = this.grid.size;
        const x = clamp(p[0], 0, nx - 1);
        const y = clamp(p[1], 0, ny - 1);
        const z = clamp(p[2], 0, nz - 1);
        const i = Math.min(Math.floor(x), Math.max(nx - 2, 0));
        const j = Math.min(Math.floor(y), Math.max(ny - 2, 0));
        const k = Math.min(Math.floor(z), Math.max(nz - 2, 0));
        const dx = nx > 1 ? 1 : 0;
        const dy = ny > 1 ? nx : 0;
        const dz = nz > 1 ? nx * ny : 0;
        const at = i + nx * (j + ny * k);
        const h = this.halves;
        const f = floatOfHalf;
        const u = x - i;
        const v = y - j;
        const w = z - k;
        const mix = (a: number, b: number, s: number): number => a + s * (b - a);
        const row = (o: number): number => mix(f[h[o]!]!, f[h[o + dx]!]!, u);
        const slice = (o: number): number => mix(row(o), row(o + dy), v);
        return mix(slice(at), slice(at + dz), w);
    }

    /// Value of the nearest voxel; undefined outside of the scan [HU].
    valueAt(ijk: Vec3): number | undefined {
        const [i, j, k] = [Math.round(ijk[0]), Math.round(ijk[1]), Math.round(ijk[2])];
        const [nx, ny, nz] = this.grid.size;
        if (i < 0 || j < 0 || k < 0 || i >= nx || j >= ny || k >= nz) return undefined;
        return floatOfHalf[this.halves[i + nx * (j + ny * k)]!];
    }

    /// Central differences along i, j, k, per voxel.
    gradient(p: Vec3): Vec3 {
        return [0, 1, 2].map((a) => {
            const before = [...p];
            const after = [...p];
            before[a] = clamp(p[a]! - 1, 0, this.grid.size[a]! - 1);
            after[a] = clamp(p[a]! + 1, 0, this.grid.size[a]! - 1);
            const width = after[a]! - before[a]!;
            if (!(width > 0)) return 0;
            const rise =
                this.sample(after as unknown as Vec3) - this.sample(before as unknown as Vec3);
            return rise / width;
        }) as unknown as Vec3;
    }

    /// Bricks with a corner in a box of voxels.
    private bricksOf(box: Box): Box {
        const begin = box.begin.map((b) => Math.max(Math.floor((b - 1) / kBrick), 0));
        const end = box.end.map((e, a) =>
            Math.min(Math.floor((e - 1) / kBrick) + 1, this.brickSize[a]!),
        );
        return { begin: begin as unknown as Vec3, end: end as unknown as Vec3 };
    }

    private computeLayers(from: number, to: number): Box {
        const [bx, by] = this.brickSize;
        return this.computeBricks({ begin: [0, 0, from], end: [bx, by, to] });
    }

    private computeBricks(bricks: Box): Box {
        const { begin, end } = bricks;
        const [nx, ny, nz] = this.grid.size;
        const [bx, by] = this.brickSize;
        const lows = new Uint16Array(bx * by); // orders of halves, of a layer
        const highs = new Uint16Array(bx * by);
        const h = this.halves;
        for (let bz = begin[2]; bz < end[2]; ++bz) {
            lows.fill(0xffff);
            highs.fill(0);
            const z1 = Math.min((bz + 1) * kBrick, nz - 1);
            const y1 = Math.min(end[1] * kBrick, ny - 1);
            for (let z = bz * kBrick; z <= z1; ++z)
                for (let y = begin[1] * kBrick; y <= y1; ++y) {
                    const row = nx * (y + ny * z);
                    // A row between two bricks belongs to both.
                    const first = Math.max(Math.ceil(y / kBrick) - 1, begin[1]);
                    const last = Math.min(Math.floor(y / kBrick), end[1] - 1);
                    for (let x = begin[0]; x < end[0]; ++x) {
                        const until = row + Math.min((x + 1) * kBrick, nx - 1);
                        let low = 0xffff;
                        let high = 0;
                        for (let o = row + x * kBrick; o <= until; ++o) {
                            const order = orderOfHalf(h[o]!);
                            if (order < low) low = order;
                            if (order > high) high = order;
                        }
                        for (let n = first; n <= last; ++n) {
                            const at = x + bx * n;
                            if (low < lows[at]!) lows[at] = low;
                            if (high > highs[at]!) highs[at] = high;
                        }
                    }
                }
            for (let y = begin[1]; y < end[1]; ++y)
                for (let x = begin[0]; x < end[0]; ++x)
                    this.setBrick(x + bx * (y + by * bz), lows[x + bx * y]!, highs[x + bx * y]!);
        }
        return bricks;
    }

    private setBrick(brick: number, low: number, high: number): void {
        const [first, second] = [halfOfOrder(low), halfOfOrder(high)];
        this.brickHalves[2 * brick] = first;
        this.brickHalves[2 * brick + 1] = second;
        this.brickRange[2 * brick] = floatOfHalf[first]!;
        this.brickRange[2 * brick + 1] = floatOfHalf[second]!;
    }
}
