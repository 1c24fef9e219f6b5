// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The endoscope's picture, or the lumen cut open and seen from outside with the endoscope in it.
// Drawn into a target of its own, which may have fewer pixels than the view (while something moves)
// or four times as many (when still).

import * as THREE from 'three';
import type { ViewRect } from './stage.ts';
import type { OverlayField } from './overlay_field.ts';
import { fieldUniforms, kNoField, overlayUniforms, Picture } from './picture.ts';
import { meteredExposure } from './exposure.ts';
import { kFieldStops, liningUniforms } from './linings.ts';
import { noiseTexture } from './noise.ts';
import { type Camera, frameOf } from './rays.ts';
import { type RestField, restUniforms } from './rest_field.ts';
import { kWaterPerMm, usualWater } from './fluoroscopy.ts';
import { kCopy, kEndoscope, kFluoroscopy } from './shaders.ts';
import { type State, surfaceOf } from './store.ts';
import { along, cross, mul, normalized, turned, type Vec3 } from './vec.ts';
import type { Vessel } from './vessel.ts';
import { kReach, VesselView } from './vessel_view.ts';
import type { VolumeTexture } from './volume_texture.ts';

const kMostTools = 8; // as in the shader
const kLightReach = 40; // [mm]
export const kOutsideField = 30; // field of view from outside [degrees]
const linear = (r: number, g: number, b: number): THREE.Vector3 =>
    new THREE.Vector3(
        ...[r, g, b].map((s) => (s <= 10 ? s / 255 / 12.92 : ((s / 255 + 0.055) / 1.055) ** 2.4)),
    );
const kSurface = linear(222, 150, 134);
const kFog = linear(8, 6, 8);
const kOwnTool = linear(120, 190, 235);
const kOtherTool = linear(235, 200, 90);

export interface ToolBall {
    readonly centre: Vec3;
    readonly radius: number;
    readonly own: boolean;
}

const vector = (v: Vec3): THREE.Vector3 => new THREE.Vector3(...v);

export class EndoscopeView {
    private readonly inside: Picture;
    private readonly outside: Picture;
    private readonly fluoroscopy: Picture;
    private readonly vessel = new VesselView();
    private volume: VolumeTexture | undefined;
    private readonly copy = new Picture(kCopy, { picture: null });
    private readonly target = new THREE.WebGLRenderTarget(1, 1, {
        minFilter: THREE.LinearFilter,
        magFilter: THREE.LinearFilter,
    });
    private readonly body = makeEndoscope();
    private readonly lens = new THREE.PerspectiveCamera(kOutsideField, 1, 1, 5000);

    constructor() {
        const common = {
            ...kNoField,
            ...restUniforms(undefined),
            eye: new THREE.Vector3(),
            right: new THREE.Vector3(),
            up: new THREE.Vector3(),
            ahead: new THREE.Vector3(),
            aspect: 1,
            slope: 1,
            barrel: 0,
            lightReach: kLightReach,
            fogDistance: 0,
            surfaceColour: kSurface,
            fogColour: kFog,
            tools: Array.from({ length: kMostTools }, () => new THREE.Vector4()),
            toolColours: Array.from({ length: kMostTools }, () => new THREE.Vector3()),
            toolCount: 0,
            ...liningUniforms('airway'),
            real: false,
            noiseTile: noiseTexture(),
            exposure: 0,
            voxelMm: 1,
            fieldStop: 0,
        };
        this.inside = new Picture(kEndoscope, { ...common, reach: kReach }, { DEPTH: '' });
        this.fluoroscopy = new Picture(kFluoroscopy, {
            ...common,
            absorption: kWaterPerMm,
            exposure: 0,
            clipFromWorld: new THREE.Matrix4(), // for the catheter's shadow
        });
        this.outside = new Picture(
            kEndoscope,
            {
                ...common,
                cutPlace: new THREE.Vector3(),
                cutNormal: new THREE.Vector3(),
                window: 1,
                level: 0,
                clipFromWorld: new THREE.Matrix4(),
            },
            { OUTSIDE: '' },
        );
    }

    setVolume(texture: VolumeTexture): void {
        this.volume = texture;
        for (const picture of [this.inside, this.outside, this.fluoroscopy])
            picture.set(fieldUniforms(texture));
    }

    setVessel(vessel: Vessel | undefined, version: number): void {
        this.vessel.update(vessel, version);
    }

    setOverlay(state: State, field: OverlayField | undefined): void {
        for (const picture of [this.inside, this.outside])
            picture.set(overlayUniforms(state, field));
    }

    setRest(field: RestField | undefined): void {
        for (const picture of [this.inside, this.outside]) picture.set(restUniforms(field));
    }

    /// @param scale  pixels of the target per pixel of the view
    draw(
        renderer: THREE.WebGLRenderer,
        state: State,
        balls: readonly ToolBall[],
        rect: ViewRect,
        scale: number,
    ): void {
        const width = Math.max(Math.round(rect.width * scale), 1);
        const height = Math.max(Math.round(rect.height * scale), 1);
        if (this.target.width !== width || this.target.height !== height)
            this.target.setSize(width, height);
        const aspect = rect.width / rect.height;
        const shadow = state.outside && state.fluoroscopy;
        const picture = shadow ? this.fluoroscopy : state.outside ? this.outside : this.inside;
        this.setCommon(picture, state, balls, aspect);
        renderer.setRenderTarget(this.target);
        if (shadow) this.drawFluoroscopy(renderer, state, aspect);
        else if (state.outside) this.drawOutside(renderer, state, aspect);
        else {
            renderer.clear(true, true, false);
            picture.draw(renderer);
        }
        if (hasVessel(state)) {
            const mode = shadow ? 'fluoroscopy' : state.outside ? 'outside' : 'inside';
            const values = Object.entries(picture.uniforms).map(([name, u]) => [name, u.value]);
            this.vessel.draw(renderer, mode, Object.fromEntries(values));
        }
        renderer.setRenderTarget(null);
        this.copy.set({ picture: this.target.texture });
        renderer.setViewport(rect.x, rect.y, rect.width, rect.height);
        renderer.setScissor(rect.x, rect.y, rect.width, rect.height);
        this.copy.draw(renderer);
    }

    private setCommon(
        picture: Picture,
        state: State,
        balls: readonly ToolBall[],
        aspect: number,
    ): void {
        const camera = state.outside ? orbitCamera(state) : state.camera;
        const frame = frameOf(camera);
        const field = state.outside ? kOutsideField : state.fieldOfView;
        picture.set({
            eye: vector(camera.eye),
            right: vector(frame.right),
            up: vector(frame.up),
            ahead: vector(frame.forward),
            aspect,
            slope: Math.tan((field * Math.PI) / 360),
            barrel: state.outside ? 0 : state.barrel,
            fogDistance: state.outside ? 0 : state.fog,
            iso: state.shared?.iso_hu ?? -500,
            rising: state.shared?.polarity !== 'falling',
            toolCount: Math.min(balls.length, kMostTools),
            real: state.style === 'real' && !state.outside,
        });
        if (picture === this.inside && state.style === 'real') this.setReal(state, aspect);
        balls.slice(0, kMostTools).forEach((ball, i) => {
            const spheres = picture.uniforms.tools!.value as THREE.Vector4[];
            const colours = picture.uniforms.toolColours!.value as THREE.Vector3[];
            spheres[i]!.set(...ball.centre, ball.radius);
            colours[i]!.copy(ball.own ? kOwnTool : kOtherTool);
        });
    }

    private setReal(state: State, aspect: number): void {
        const { data } = this.volume!;
        const [sx, sy, sz] = data.grid.spacing;
        const { camera, fieldOfView, barrel, lining, fieldStop } = state;
        const surface = surfaceOf(state);
        this.inside.set({
            ...liningUniforms(lining),
            exposure: meteredExposure(data, camera, fieldOfView, barrel, aspect, surface),
            voxelMm: Math.min(Math.max(Math.cbrt(sx * sy * sz), 0.4), 1.2),
            fieldStop: kFieldStops.indexOf(fieldStop),
        });
    }

    private drawFluoroscopy(renderer: THREE.WebGLRenderer, state: State, aspect: number): void {
        this.aimLens(state, aspect);
        const { data } = this.volume!;
        const usual = usualWater(data, orbitCamera(state), kOutsideField, aspect);
        const absorption = kWaterPerMm * state.fluoroContrast;
        this.fluoroscopy.set({
            absorption,
            exposure: usual + Math.log(state.fluoroExposure) / absorption,
            clipFromWorld: this.clipFromWorld(),
        });
        renderer.clear(true, true, false);
        this.fluoroscopy.draw(renderer);
    }

    private clipFromWorld(): THREE.Matrix4 {
        const { projectionMatrix, matrixWorldInverse } = this.lens;
        return new THREE.Matrix4().multiplyMatrices(projectionMatrix, matrixWorldInverse);
    }

    private aimLens(state: State, aspect: number): void {
        const camera = orbitCamera(state);
        this.lens.aspect = aspect;
        this.lens.near = Math.max(state.orbit.distance * 0.02, 0.5);
        this.lens.far = state.orbit.distance * 20;
        this.lens.position.set(...camera.eye);
        this.lens.up.set(...frameOf(camera).up);
        this.lens.lookAt(vector(state.orbit.centre));
        this.lens.updateProjectionMatrix();
        this.lens.updateMatrixWorld();
    }

    private drawOutside(renderer: THREE.WebGLRenderer, state: State, aspect: number): void {
        const { camera } = state;
        this.aimLens(state, aspect);
        this.outside.set({
            cutPlace: vector(camera.eye),
            cutNormal: vector(mul(-1, orbitCamera(state).look)), // it faces the viewer
            window: state.window,
            level: state.level,
            clipFromWorld: this.clipFromWorld(),
        });
        renderer.clear(true, true, false);
        this.outside.draw(renderer);
        placeEndoscope(this.body, state);
        renderer.render(this.body, this.lens);
    }
}

/// Whether the wall and the catheter are there now, and not only voxels.
const hasVessel = (state: State): boolean => state.shared?.tissue?.model === 'vessel';

/// The camera that looks at the lumen from outside.
export function orbitCamera(state: State): Camera {
    const { centre, direction, up, distance } = state.orbit;
    return { eye: along(centre, -distance, direction), look: direction, up };
}

/// Shaft, tip and what it sees, along +y from the tip at the origin.
function makeEndoscope(): THREE.Scene {
    const scene = new THREE.Scene();
    const tool = new THREE.Group();
    tool.name = 'endoscope';
    const metal = new THREE.MeshBasicMaterial({ color: 0x78beeb });
    const dark = new THREE.MeshBasicMaterial({ color: 0x2d5d80 });
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(0.8, 0.8, 1, 24), dark);
    shaft.name = 'shaft';
    const tip = new THREE.Mesh(new THREE.SphereGeometry(1, 24, 16), metal);
    tip.name = 'tip';
    const sight = new THREE.Mesh(
        new THREE.ConeGeometry(1, 1, 32, 1, true),
        new THREE.MeshBasicMaterial({
            color: 0xffe9a8,
            transparent: true,
            opacity: 0.3,
            side: THREE.DoubleSide,
            depthWrite: false,
        }),
    );
    sight.name = 'sight';
    tool.add(shaft, tip, sight);
    scene.add(tool);
    return scene;
}

function placeEndoscope(scene: THREE.Scene, state: State): void {
    const tool = scene.getObjectByName('endoscope')!;
    const { forward } = frameOf(state.camera);
    tool.position.set(...state.camera.eye);
    tool.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), vector(forward));
    const shaft = tool.getObjectByName('shaft')!;
    const length = 40;
    shaft.scale.set(state.tip, length, state.tip);
    shaft.position.y = -length / 2;
    tool.getObjectByName('tip')!.scale.setScalar(state.tip);
    const sight = tool.getObjectByName('sight')!;
    const reach = 12;
    const wide = reach * Math.tan((Math.min(state.fieldOfView, 110) * Math.PI) / 360);
    sight.scale.set(wide, -reach, wide);
    sight.position.y = reach / 2;
}

/// Turns the outside view by angles about its own axes [radians].
export function orbitTurned(orbit: State['orbit'], yaw: number, pitch: number): State['orbit'] {
    const right = normalized(cross(orbit.direction, orbit.up));
    const side = turned(right, orbit.up, yaw);
    const direction = normalized(turned(turned(orbit.direction, orbit.up, yaw), side, pitch));
    return { ...orbit, direction, up: cross(side, direction) };
}
