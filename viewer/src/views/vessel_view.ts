// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Wall of the vessel as a transparent mesh, drawn over the outside view. Only positions change. The
// catheter is drawn by the ray casting shaders (catheter_texture.ts).

import * as THREE from 'three';
import type { Vessel } from '../net/vessel.ts';
import { kVesselFragment, kVesselVertex } from './shaders.ts';

const kWarmMm = 1;
const kWall = {
    own: [0.93, 0.62, 0.55],
    warm: [1, 0.9, 0.3],
    clear: 0.1,
    rim: 0.55,
    dense: 0.7,
} as const;

export class VesselView {
    private readonly uniforms: Record<string, THREE.IUniform> = {
        eye: { value: new THREE.Vector3() },
        clipFromWorld: { value: new THREE.Matrix4() },
        warmAt: { value: kWarmMm },
        own: { value: new THREE.Vector3(...kWall.own) },
        warm: { value: new THREE.Vector3(...kWall.warm) },
        clear: { value: kWall.clear },
        rim: { value: kWall.rim },
        dense: { value: kWall.dense },
    };
    private readonly wall = new THREE.BufferGeometry();
    private readonly scene = new THREE.Scene();
    private readonly camera = new THREE.Camera();
    private vessel: Vessel | undefined;
    private shown = -1;

    constructor() {
        const material = new THREE.RawShaderMaterial({
            glslVersion: THREE.GLSL3,
            vertexShader: kVesselVertex,
            fragmentShader: kVesselFragment,
            uniforms: this.uniforms,
            transparent: true,
            depthWrite: false,
            side: THREE.DoubleSide,
        });
        const mesh = new THREE.Mesh(this.wall, material);
        mesh.frustumCulled = false;
        this.scene.add(mesh);
    }

    /// Takes over a vessel. @param version  differs after each change
    update(vessel: Vessel | undefined, version: number): void {
        if (version === this.shown) return;
        this.shown = version;
        if (vessel && vessel !== this.vessel) setWall(this.wall, vessel);
        this.vessel = vessel;
        if (!vessel) return;
        const { position, moved } = this.wall.attributes;
        (position as THREE.BufferAttribute).needsUpdate = true;
        (moved as THREE.BufferAttribute).needsUpdate = true;
    }

    draw(renderer: THREE.WebGLRenderer, eye: THREE.Vector3, clipFromWorld: THREE.Matrix4): void {
        if (!this.vessel) return;
        this.uniforms.eye!.value = eye;
        this.uniforms.clipFromWorld!.value = clipFromWorld;
        renderer.render(this.scene, this.camera);
    }
}

/// Sets the mesh, with its normals at rest: the wall moves little.
function setWall(geometry: THREE.BufferGeometry, vessel: Vessel): void {
    geometry.setIndex(new THREE.BufferAttribute(vessel.corners, 1));
    geometry.setAttribute('position', new THREE.BufferAttribute(vessel.rest, 3));
    geometry.computeVertexNormals();
    geometry.setAttribute('position', new THREE.BufferAttribute(vessel.places, 3));
    geometry.setAttribute('moved', new THREE.BufferAttribute(vessel.moved, 1));
}
