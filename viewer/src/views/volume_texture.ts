// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Texture of the volume: uploaded once as a 3-D texture of half floats, then patched box by box
// from the mirror. three.js has no cheap way to patch, so texSubImage3D is called with its
// texture's handle.

import * as THREE from 'three';
import { type Box, boxCount, isEmpty } from '../maths/grid.ts';
import type { Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';

/// Number of pending boxes above which they are merged into one.
const kMaxBoxes = 64;

/// Pending uploads of boxes of a texture, from the texture's own data.
export class BoxUploads {
    private pending: Box[] = [];

    constructor(
        private readonly texture: THREE.Data3DTexture,
        private readonly size: Vec3,
        private readonly format: 'RED' | 'RG' | 'RGBA',
    ) {}

    add(box: Box): void {
        if (!isEmpty(box)) this.pending.push(box);
        if (this.pending.length > kMaxBoxes) this.pending = [joined(this.pending)];
    }

    /// Uploads the pending boxes. @returns the number of texels
    send(renderer: THREE.WebGLRenderer): number {
        const sent = uploadBoxes(renderer, this.texture, this.pending, this.size, this.format);
        this.pending = [];
        return sent;
    }

    /// Allocates the texture before its values are there: only boxes are uploaded.
    reserve(renderer: THREE.WebGLRenderer): void {
        this.texture.source.dataReady = false;
        renderer.initTexture(this.texture);
    }

    /// Uploads everything again at the next use.
    restore(): void {
        this.texture.source.dataReady = true;
        this.texture.needsUpdate = true;
        this.pending = [];
    }
}

export class VolumeTexture {
    readonly volume: THREE.Data3DTexture;
    readonly bricks: THREE.Data3DTexture;
    private readonly voxelUploads: BoxUploads;
    private readonly brickUploads: BoxUploads;

    constructor(readonly data: VolumeData) {
        this.volume = makeTexture(data.halves, data.grid.size);
        this.bricks = makeTexture(data.brickHalves, data.brickSize, THREE.RGFormat);
        this.bricks.minFilter = this.bricks.magFilter = THREE.NearestFilter;
        this.voxelUploads = new BoxUploads(this.volume, data.grid.size, 'RED');
        this.brickUploads = new BoxUploads(this.bricks, data.brickSize, 'RG');
    }

    patch(box: Box, halves: Uint16Array): void {
        this.brickUploads.add(this.data.patch(box, halves));
        this.voxelUploads.add(box);
    }

    /// Uploads the boxes of a scan that is being loaded as they come. Otherwise the first use
    /// uploads all of it.
    reserve(renderer: THREE.WebGLRenderer): void {
        this.voxelUploads.reserve(renderer);
        this.brickUploads.reserve(renderer);
    }

    /// Writes a box of a scan that is being loaded. The last one completes the bricks.
    fill(box: Box, halves: Uint16Array, last: boolean): void {
        this.brickUploads.add(this.data.fill(box, halves));
        this.voxelUploads.add(box);
        if (last) this.brickUploads.add(this.data.finish());
    }

    /// Uploads the boxes patched since the last call. @returns the number of voxels
    upload(renderer: THREE.WebGLRenderer): number {
        this.brickUploads.send(renderer);
        return this.voxelUploads.send(renderer);
    }

    /// Uploads everything again from the mirror, after a loss of the graphics context.
    restore(): void {
        this.voxelUploads.restore();
        this.brickUploads.restore();
    }

    dispose(): void {
        this.volume.dispose();
        this.bricks.dispose();
    }
}

/// Creates a texture of half floats with linear interpolation.
export function makeTexture(
    data: Uint16Array,
    size: Vec3,
    format: THREE.PixelFormat = THREE.RedFormat,
): THREE.Data3DTexture {
    const texture = new THREE.Data3DTexture(data as Uint16Array<ArrayBuffer>, ...size);
    texture.format = format;
    texture.type = THREE.HalfFloatType;
    texture.minFilter = texture.magFilter = THREE.LinearFilter;
    texture.unpackAlignment = 2;
    texture.needsUpdate = true;
    return texture;
}

function joined(boxes: readonly Box[]): Box {
    const begin = [0, 1, 2].map((a) => Math.min(...boxes.map((b) => b.begin[a]!)));
    const end = [0, 1, 2].map((a) => Math.max(...boxes.map((b) => b.end[a]!)));
    return { begin: begin as unknown as Vec3, end: end as unknown as Vec3 };
}

function uploadBoxes(
    renderer: THREE.WebGLRenderer,
    texture: THREE.Data3DTexture,
    boxes: readonly Box[],
    size: Vec3,
    format: 'RED' | 'RG' | 'RGBA',
): number {
    const properties = renderer.properties.get(texture) as { __webglTexture?: WebGLTexture };
    const handle = properties.__webglTexture;
    if (!boxes.length || !handle) return 0; // not created yet: the first use uploads everything
    const gl = renderer.getContext() as WebGL2RenderingContext;
    const state = renderer.state as unknown as {
        bindTexture(target: number, handle: WebGLTexture): void;
        pixelStorei(name: number, value: number): void;
    };
    state.bindTexture(gl.TEXTURE_3D, handle);
    state.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, 0);
    state.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, 0);
    state.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
    state.pixelStorei(gl.UNPACK_ROW_LENGTH, size[0]);
    state.pixelStorei(gl.UNPACK_IMAGE_HEIGHT, size[1]);
    let sent = 0;
    for (const box of boxes) {
        if (isEmpty(box)) continue;
        const [x, y, z] = box.begin;
        state.pixelStorei(gl.UNPACK_SKIP_PIXELS, x);
        state.pixelStorei(gl.UNPACK_SKIP_ROWS, y);
        state.pixelStorei(gl.UNPACK_SKIP_IMAGES, z);
        gl.texSubImage3D(
            gl.TEXTURE_3D,
            0,
            x,
            y,
            z,
            box.end[0] - x,
            box.end[1] - y,
            box.end[2] - z,
            gl[format],
            gl.HALF_FLOAT,
            texture.image.data as unknown as Uint16Array,
        );
        sent += boxCount(box);
    }
    for (const name of ['ROW_LENGTH', 'IMAGE_HEIGHT', 'SKIP_PIXELS', 'SKIP_ROWS', 'SKIP_IMAGES'])
        state.pixelStorei(gl[`UNPACK_${name}` as 'UNPACK_ROW_LENGTH'], 0);
    return sent;
}
