// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The vessel's wall as a mesh that one sees through, and the catheter as a tube, drawn over the
// endoscope's picture, the outside view or fluoroscopy. The tube is made anew from its points with
// each picture; of the wall only places change.

import * as THREE from 'three';
import { kVesselFragment, kVesselVertex } from './shaders.ts';
import { along as alongBy, cross, norm, normalized, sub, type Vec3 } from './vec.ts';
import type { Vessel } from './vessel.ts';

/// Depth 1 in the endoscope's picture, whose shader writes distances.
export const kReach = 2000; // [mm]
const kSectors = 10;
const kBetween = 3; // parts of the curve from one point to the next
const kWarmMm = 1;

const kWall = { own: [0.93, 0.62, 0.55], warm: [1, 0.9, 0.3], clear: 0.1, rim: 0.55 } as const;
const kTube = { own: [0.45, 0.8, 0.98], warm: [0.45, 0.8, 0.98], clear: 1, rim: 1 } as const;
const kShadow = { own: [0.04, 0.04, 0.04], warm: [0, 0, 0], clear: 0.85, rim: 0.85 } as const;

export type VesselMode = 'inside' | 'outside' | 'fluoroscopy';

export class VesselView {
    private readonly uniforms: Record<string, THREE.IUniform> = {
        eye: { value: new THREE.Vector3() },
        right: { value: new THREE.Vector3() },
        up: { value: new THREE.Vector3() },
        ahead: { value: new THREE.Vector3() },
        aspect: { value: 1 },
        slope: { value: 1 },
        barrel: { value: 0 },
        clipFromWorld: { value: new THREE.Matrix4() },
        warmAt: { value: kWarmMm },
        reach: { value: kReach },
    };
    private readonly wall = new THREE.BufferGeometry();
    private readonly tube = new THREE.BufferGeometry();
    private readonly scenes: Record<VesselMode, THREE.Scene>;
    private readonly camera = new THREE.Camera();
    private vessel: Vessel | undefined;
    private shown = -1;

    constructor() {
        const wall = this.material(kWall, { OUTSIDE: '' }, true);
        // What is behind something shimmers through.
        const hidden = this.material({ ...kTube, clear: 0.3, rim: 0.3 }, { OUTSIDE: '' }, true);
        hidden.depthTest = false;
        const shadow = this.material(kShadow, { OUTSIDE: '', SHADOW: '' }, true);
        shadow.depthTest = false;
        this.scenes = {
            inside: sceneOf([this.tube, this.material(kTube, {}, false)]),
            outside: sceneOf(
                [this.tube, hidden],
                [this.tube, this.material(kTube, { OUTSIDE: '' }, false)],
                [this.wall, wall],
            ),
            fluoroscopy: sceneOf([this.tube, shadow]),
        };
    }

    /// @param version  grows with each change of the vessel
    update(vessel: Vessel | undefined, version: number): void {
        if (version === this.shown) return;
        this.shown = version;
        if (vessel && vessel !== this.vessel) setWall(this.wall, vessel);
        this.vessel = vessel;
        if (!vessel) return;
        const { position, moved } = this.wall.attributes;
        (position as THREE.BufferAttribute).needsUpdate = true;
        (moved as THREE.BufferAttribute).needsUpdate = true;
        setTube(this.tube, vessel.catheter, vessel.radius);
    }

    /// @param values  of the uniforms that say where the camera is
    draw(renderer: THREE.WebGLRenderer, mode: VesselMode, values: Record<string, unknown>): void {
        if (!this.vessel) return;
        for (const name of Object.keys(this.uniforms))
            if (name in values) this.uniforms[name]!.value = values[name];
        renderer.render(this.scenes[mode], this.camera);
    }

    private material(
        look: { own: readonly number[]; warm: readonly number[]; clear: number; rim: number },
        defines: Record<string, string>,
        seeThrough: boolean,
    ): THREE.RawShaderMaterial {
        return new THREE.RawShaderMaterial({
            glslVersion: THREE.GLSL3,
            vertexShader: kVesselVertex,
            fragmentShader: kVesselFragment,
            uniforms: {
                ...this.uniforms,
                own: { value: new THREE.Vector3(...look.own) },
                warm: { value: new THREE.Vector3(...look.warm) },
                clear: { value: look.clear },
                rim: { value: look.rim },
            },
            defines,
            transparent: seeThrough,
            depthWrite: !seeThrough,
            side: THREE.DoubleSide,
        });
    }
}

function sceneOf(...parts: [THREE.BufferGeometry, THREE.Material][]): THREE.Scene {
    const scene = new THREE.Scene();
    parts.forEach(([geometry, material], n) => {
        const mesh = new THREE.Mesh(geometry, material);
        mesh.frustumCulled = false;
        mesh.renderOrder = n;
        scene.add(mesh);
    });
    return scene;
}

/// Normals are those at rest: the wall moves little.
function setWall(geometry: THREE.BufferGeometry, vessel: Vessel): void {
    geometry.setIndex(new THREE.BufferAttribute(vessel.corners, 1));
    geometry.setAttribute('position', new THREE.BufferAttribute(vessel.rest, 3));
    geometry.computeVertexNormals();
    geometry.setAttribute('position', new THREE.BufferAttribute(vessel.places, 3));
    geometry.setAttribute('moved', new THREE.BufferAttribute(vessel.moved, 1));
}

function setTube(geometry: THREE.BufferGeometry, points: readonly Vec3[], radius: number): void {
    const { positions, normals, corners } = tubeAround(smoothed(points), radius);
    geometry.setIndex(new THREE.BufferAttribute(corners, 1));
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3));
    const moved = new Float32Array(positions.length / 3);
    geometry.setAttribute('moved', new THREE.BufferAttribute(moved, 1));
}

/// A curve of Catmull and Rom through the points.
export function smoothed(points: readonly Vec3[]): Vec3[] {
    const curve: Vec3[] = [];
    const at = (n: number): Vec3 => points[Math.min(Math.max(n, 0), points.length - 1)]!;
    for (let n = 0; n + 1 < points.length; ++n)
        for (let k = 0; k < kBetween; ++k) {
            const t = k / kBetween;
            const weights = [
                -t + 2 * t * t - t ** 3,
                2 - 5 * t * t + 3 * t ** 3,
                t + 4 * t * t - 3 * t ** 3,
                -t * t + t ** 3,
            ];
            const p: [number, number, number] = [0, 0, 0];
            weights.forEach((w, i) => {
                for (let a = 0; a < 3; ++a) p[a]! += (w / 2) * at(n - 1 + i)[a]!;
            });
            curve.push(p);
        }
    if (points.length) curve.push(points[points.length - 1]!);
    return curve;
}

/// Rings around a curve, turned as little as possible from one to the next, and a cap at its end.
export function tubeAround(
    curve: readonly Vec3[],
    radius: number,
): { positions: Float32Array; normals: Float32Array; corners: Uint32Array } {
    const count = curve.length < 2 ? 0 : curve.length;
    const positions = new Float32Array(3 * (count * kSectors + (count ? 1 : 0)));
    const normals = new Float32Array(positions.length);
    const corners: number[] = [];
    let side: Vec3 = [0, 0, 0];
    const put = (n: number, place: Vec3, normal: Vec3): void => {
        positions.set(place, 3 * n);
        normals.set(normal, 3 * n);
    };
    for (let n = 0; n < count; ++n) {
        const [before, after] = [curve[Math.max(n - 1, 0)]!, curve[Math.min(n + 1, count - 1)]!];
        const along = normalized(sub(after, before));
        const flat = cross(along, norm(side) > 0 ? side : [along[1], along[2], along[0]]);
        const over = norm(flat) > 1e-6 ? normalized(flat) : normalized(cross(along, [1, 0.3, 0.1]));
        side = cross(over, along);
        for (let s = 0; s < kSectors; ++s) {
            const angle = (2 * Math.PI * s) / kSectors;
            const out = [0, 1, 2].map(
                (a) => Math.cos(angle) * side[a]! + Math.sin(angle) * over[a]!,
            ) as unknown as Vec3;
            put(n * kSectors + s, alongBy(curve[n]!, radius, out), out);
            const next = (s + 1) % kSectors;
            const [i, j] = [n * kSectors + s, n * kSectors + next];
            if (n + 1 < count) corners.push(i, j, i + kSectors, j, j + kSectors, i + kSectors);
            else corners.push(i, j, count * kSectors);
        }
        if (n + 1 === count) put(count * kSectors, alongBy(curve[n]!, radius, along), along);
    }
    return { positions, normals, corners: new Uint32Array(corners) };
}
