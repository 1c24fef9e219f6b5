// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mirror of half floats on a grid, one or four per node, patched by boxes, with its texture.

import * as THREE from 'three';
import type { Box } from '../maths/grid.ts';
import type { Vec3 } from '../maths/vec.ts';
import { writeBox } from '../maths/volume.ts';
import { BoxUploads, makeTexture } from './volume_texture.ts';

export class HalfField {
    readonly halves: Uint16Array;
    readonly texture: THREE.Data3DTexture;
    private readonly uploads: BoxUploads;

    /// Creates a field of zeros.
    /// @param name  for messages
    /// @param counts  nodes along each axis
    /// @param components  halves per node
    constructor(
        private readonly name: string,
        readonly counts: Vec3,
        private readonly components: 1 | 4,
    ) {
        const [nx, ny, nz] = counts;
        this.halves = new Uint16Array(components * nx * ny * nz);
        const format = components === 4 ? THREE.RGBAFormat : THREE.RedFormat;
        this.texture = makeTexture(this.halves, counts, format);
        this.uploads = new BoxUploads(this.texture, counts, components === 4 ? 'RGBA' : 'RED');
    }

    /// Writes the values of a box of nodes.
    patch(box: Box, values: Uint16Array): void {
        if (box.end.some((end, a) => end > this.counts[a]!)) {
            const [end, counts] = [box.end, this.counts].map((n) => n.join('×'));
            throw new Error(`${this.name}: box up to ${end}, has ${counts}`);
        }
        const wide = ([x, y, z]: Vec3): Vec3 => [this.components * x, y, z];
        const halves = { begin: wide(box.begin), end: wide(box.end) };
        writeBox(this.halves, wide(this.counts), halves, values);
        this.uploads.add(box);
    }

    /// Uploads patched boxes to the graphics processor. @returns the number of nodes
    upload(renderer: THREE.WebGLRenderer): number {
        return this.uploads.send(renderer);
    }
    /// Uploads everything again, after a loss of the graphics context.
    restore(): void {
        this.uploads.restore();
    }
    dispose(): void {
        this.texture.dispose();
    }
}
