// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Fragment shader over a rectangle: all views are drawn with it.

import * as THREE from 'three';
import { kColours } from '../maths/colour_map.ts';
import { voxelFromWorldMatrix } from '../maths/grid.ts';
import { kKinds, rangeOf } from '../state/overlay_kinds.ts';
import type { State } from '../state/state.ts';
import type { OverlayField } from './overlay_field.ts';
import { kFullScreen } from './shaders.ts';
import type { VolumeTexture } from './volume_texture.ts';

type Uniforms = Record<string, THREE.IUniform>;

/// Rectangle in pixels of the canvas, from its lower left corner.
export interface ViewRect {
    x: number;
    y: number;
    width: number;
    height: number;
}

const triangle = new THREE.BufferGeometry();
triangle.setAttribute(
    'position',
    new THREE.BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3),
);
const camera = new THREE.Camera();

export class Picture {
    readonly uniforms: Uniforms;
    readonly mesh: THREE.Mesh;
    private readonly scene = new THREE.Scene();

    constructor(
        fragment: string,
        uniforms: Record<string, unknown>,
        defines: Record<string, string> = {},
    ) {
        this.uniforms = Object.fromEntries(
            Object.entries(uniforms).map(([name, value]) => [name, { value }]),
        );
        const writesDepth = 'OUTSIDE' in defines || 'DEPTH' in defines;
        const material = new THREE.RawShaderMaterial({
            glslVersion: THREE.GLSL3,
            vertexShader: kFullScreen,
            fragmentShader: fragment,
            uniforms: this.uniforms,
            defines,
            depthTest: writesDepth,
            depthWrite: writesDepth,
        });
        if (writesDepth) material.depthFunc = THREE.AlwaysDepth;
        this.mesh = new THREE.Mesh(triangle, material);
        this.mesh.frustumCulled = false;
        this.scene.add(this.mesh);
    }

    set(values: Record<string, unknown>): void {
        for (const [name, value] of Object.entries(values)) this.uniforms[name]!.value = value;
    }

    /// Sets or removes preprocessor symbols of the shader; programs are kept.
    define(symbols: Record<string, boolean>): void {
        const material = this.mesh.material as THREE.RawShaderMaterial;
        for (const [name, wanted] of Object.entries(symbols)) {
            if (name in material.defines === wanted) continue;
            if (wanted) material.defines[name] = '';
            else delete material.defines[name];
            material.needsUpdate = true;
        }
    }

    draw(renderer: THREE.WebGLRenderer): void {
        renderer.render(this.scene, camera);
    }
}

/// Uniforms of shaders/field.glsl and surface.glsl for a volume.
export function fieldUniforms(texture: VolumeTexture): Record<string, unknown> {
    const { grid, brickSize } = texture.data;
    return {
        volume: texture.volume,
        size: new THREE.Vector3(...grid.size),
        voxelFromWorld: new THREE.Matrix4().fromArray(voxelFromWorldMatrix(grid)),
        bricks: texture.bricks,
        brickCount: new THREE.Vector3(...brickSize),
    };
}

/// Uniforms of shaders/overlay.glsl.
export function overlayUniforms(
    state: State,
    field: OverlayField | undefined,
): Record<string, unknown> {
    const { kind, opacity } = state.overlay;
    if (!field || kind !== field.kind) return { overlayOn: false, overlayField: null };
    const { rest, colours } = kKinds[field.kind];
    const { low, high } = rangeOf(state);
    return {
        overlayOn: true,
        overlayField: field.texture,
        overlayRest: rest,
        overlayRange: new THREE.Vector2(low, high),
        overlayOpacity: opacity,
        overlayColours: colours.map((colour) => new THREE.Vector3(...colour)),
    };
}

/// Uniforms without a volume, to create the material.
export const kNoField: Record<string, unknown> = {
    overlayField: null,
    overlayOn: false,
    overlayRest: 0,
    overlayRange: new THREE.Vector2(0, 1),
    overlayOpacity: 0,
    overlayColours: Array.from({ length: kColours }, () => new THREE.Vector3()),
    volume: null,
    size: new THREE.Vector3(1, 1, 1),
    voxelFromWorld: new THREE.Matrix4(),
    bricks: null,
    brickCount: new THREE.Vector3(1, 1, 1),
    iso: -500,
    rising: true,
};
