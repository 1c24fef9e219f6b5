// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Picture of the endoscope, of the lumen cut open and seen from outside, of the whole scan as a
// volume, or of fluoroscopy. It is drawn into a target with fewer pixels than the view (while
// something moves) or four times as many (when still), or as the mean of several pictures with
// shifted rays.

import * as THREE from 'three';
import { frameOf } from '../maths/rays.ts';
import { along, mul, type Vec3 } from '../maths/vec.ts';
import type { Vessel } from '../net/vessel.ts';
import {
    hasVessel,
    kFieldStops,
    type State,
    surfaceOf,
    tipIsInScan,
    type View,
} from '../state/state.ts';
import { CatheterTexture, kNoCatheter } from './catheter_texture.ts';
import { lampReach, meteredExposure } from './exposure.ts';
import { kWaterPerMm, projectionOf, usualWater } from './fluoroscopy.ts';
import { scaleOf } from '../state/units.ts';
import { headOpacity, instrumentOf, kKinds, lumenOf, type ToolBall } from './instruments.ts';
import { kNoLabels } from './label_field.ts';
import { liningOf, liningUniforms } from './linings.ts';
import { noiseTexture } from './noise.ts';
import { kOutsideField, orbitCamera } from './orbit.ts';
import type { OverlayField } from './overlay_field.ts';
import { fieldUniforms, kNoField, overlayUniforms, Picture, type ViewRect } from './picture.ts';
import { type RestField, restUniforms } from './rest_field.ts';
import { kBlend, kCopy, kEndoscope, kFluoroscopy } from './shaders.ts';
import { VesselView } from './vessel_view.ts';
import type { VolumeTexture } from './volume_texture.ts';
import { kNoTransfer, transferUniforms } from './volume_view.ts';

const kReach = 2000; // distance of depth 1 in the endoscope's picture [mm]
const kMaxTools = 9; // as in the shader: eight, and the endoscope from outside
/// Ray offsets of the pictures that are averaged: a rotated grid [pixels].
export const kPasses: readonly (readonly [number, number])[] = [
    [-0.125, -0.375],
    [0.375, -0.125],
    [0.125, 0.375],
    [-0.375, 0.125],
];
const kLightReach = 40; // distance at which the light is halved [mm]
const kCatheterPixels = 3; // smallest width of a catheter from outside
const linear = (r: number, g: number, b: number): THREE.Vector3 =>
    new THREE.Vector3(
        ...[r, g, b].map((s) => (s <= 10 ? s / 255 / 12.92 : ((s / 255 + 0.055) / 1.055) ** 2.4)),
    );
const kSurface = linear(222, 150, 134);
const kFog = linear(8, 6, 8);
const kOwnTool = linear(120, 190, 235);
const kOtherTool = linear(235, 200, 90);

export interface Drawing {
    readonly seed?: number; ///< of the quantum noise
    /// Index of kPasses: the mean of the passes so far is shown; absent: a single picture.
    readonly pass?: number | undefined;
    /// Rows that are drawn, from below; absent: all.
    readonly band?: { readonly from: number; readonly rows: number } | undefined;
    readonly moving?: boolean | undefined; ///< the picture may be coarser
}

const vector = (v: Vec3): THREE.Vector3 => new THREE.Vector3(...v);

export class EndoscopeView {
    private readonly inside: Picture;
    private readonly outside: Picture;
    private readonly fluoroscopy: Picture;
    private readonly blended: Picture;
    private readonly vessel = new VesselView();
    private readonly catheter = new CatheterTexture();
    private readonly noise = noiseTexture();
    private vesselShown = -1;
    private volume: VolumeTexture | undefined;
    private rest: RestField | undefined;
    private readonly copy = new Picture(kCopy, { picture: null, share: 1 });
    private readonly target = new THREE.WebGLRenderTarget(1, 1, {
        minFilter: THREE.LinearFilter,
        magFilter: THREE.LinearFilter,
    });
    private readonly body = makeSight();
    private readonly lens = new THREE.PerspectiveCamera(kOutsideField, 1, 1, 5000);

    constructor() {
        (this.copy.mesh.material as THREE.Material).transparent = true; // blended by its share
        const common = {
            ...kNoField,
            ...kNoLabels,
            ...restUniforms(undefined),
            ...kNoCatheter(),
            eye: new THREE.Vector3(),
            right: new THREE.Vector3(),
            up: new THREE.Vector3(),
            ahead: new THREE.Vector3(),
            aspect: 1,
            slope: 1,
            barrel: 0,
            jitter: new THREE.Vector2(),
            lightReach: kLightReach,
            fogDistance: 0,
            surfaceColour: kSurface,
            fogColour: kFog,
            tools: Array.from({ length: kMaxTools }, () => new THREE.Vector4()),
            toolColours: Array.from({ length: kMaxTools }, () => new THREE.Vector3()),
            toolBases: Array.from({ length: kMaxTools }, () => new THREE.Vector4()),
            toolWrists: Array.from({ length: kMaxTools }, () => new THREE.Vector3()),
            toolAxes: Array.from({ length: kMaxTools }, () => new THREE.Vector3()),
            toolSides: Array.from({ length: kMaxTools }, () => new THREE.Vector4()),
            toolKinds: Array.from({ length: kMaxTools }, () => 0),
            toolOpacities: Array.from({ length: kMaxTools }, () => 1),
            toolCount: 0,
            ...liningUniforms('airway'),
            noiseTile: this.noise,
            exposure: 0,
            spacingMm: 1,
            voxelMm: 1,
            fieldStop: 0,
        };
        this.inside = new Picture(kEndoscope, { ...common, reach: kReach }, { DEPTH: '' });
        this.fluoroscopy = new Picture(kFluoroscopy, {
            ...common,
            absorption: kWaterPerMm,
            contrast: 1,
            slab: new THREE.Vector2(),
            margin: new THREE.Vector3(),
            noise: 0,
            seed: 0,
            pixels: new THREE.Vector2(),
        });
        this.blended = new Picture(kBlend, { ...common, ...kNoTransfer() });
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
        for (const picture of [this.inside, this.outside, this.fluoroscopy, this.blended])
            picture.set(fieldUniforms(texture));
    }

    setVessel(vessel: Vessel | undefined, version: number): void {
        this.vessel.update(vessel, version);
        if (version === this.vesselShown) return;
        this.vesselShown = version;
        this.catheter.update(vessel?.catheter ?? [], vessel?.radius ?? 1);
    }

    setOverlay(state: State, field: OverlayField | undefined): void {
        for (const picture of [this.inside, this.outside, this.blended])
            picture.set(overlayUniforms(state, field));
    }

    /// @param uniforms  of shaders/labels.glsl; undefined: without labels
    setLabels(uniforms: Record<string, unknown> | undefined): void {
        for (const picture of [this.inside, this.outside]) {
            if (uniforms) picture.set(uniforms);
            picture.define({ LABELS: uniforms !== undefined });
        }
    }

    setRest(field: RestField | undefined): void {
        this.rest = field;
        for (const picture of [this.inside, this.outside]) picture.set(restUniforms(field));
    }

    /// Compiles the program with instruments, so that the first one appears at once.
    prepareInstruments(renderer: THREE.WebGLRenderer): void {
        this.inside.define({ INSTRUMENTS: true });
        this.target.setSize(1, 1);
        this.target.scissorTest = false;
        renderer.setRenderTarget(this.target);
        this.inside.draw(renderer);
        renderer.setRenderTarget(null);
    }

    /// Frees the resources of the graphics processor; drawing makes them anew.
    dispose(): void {
        this.target.dispose();
        this.catheter.dispose();
        this.noise.dispose();
    }

    /// Draws into a rectangle of the canvas.
    /// @param scale  pixels of the target per pixel of the view; 1 for a band
    draw(
        renderer: THREE.WebGLRenderer,
        state: State,
        balls: readonly ToolBall[],
        rect: ViewRect,
        scale: number,
        { seed = 0, pass, band, moving = false }: Drawing = {},
    ): void {
        const width = Math.max(Math.round(rect.width * scale), 1);
        const height = Math.max(Math.round(rect.height * scale), 1);
        if (this.target.width !== width || this.target.height !== height)
            this.target.setSize(width, height);
        const aspect = rect.width / rect.height;
        const { outside } = state.view;
        const shadow = outside && state.view.fluoroscopy;
        const blended = outside && !shadow && state.view.blended;
        const fromOutside = blended ? this.blended : this.outside;
        const picture = shadow ? this.fluoroscopy : outside ? fromOutside : this.inside;
        this.setCommon(picture, state, balls, rect);
        const [dx, dy] = pass === undefined ? [0, 0] : kPasses[pass]!;
        const jitter = new THREE.Vector2((2 * dx) / width, (2 * dy) / height);
        picture.set({ jitter });
        const { from, rows } = band ?? { from: 0, rows: rect.height };
        this.target.scissorTest = band !== undefined;
        this.target.scissor.set(0, from, width, rows);
        renderer.setRenderTarget(this.target);
        if (shadow) this.drawFluoroscopy(renderer, state, rect, seed);
        else if (blended) this.drawBlended(renderer, state, moving, pass);
        else if (outside) this.drawOutside(renderer, state, aspect, jitter);
        else {
            renderer.clear(true, true, false);
            picture.draw(renderer);
        }
        renderer.setRenderTarget(null);
        this.copy.set({ picture: this.target.texture, share: 1 / ((pass ?? 0) + 1) });
        renderer.setViewport(rect.x, rect.y, rect.width, rect.height);
        renderer.setScissor(rect.x, rect.y + from, rect.width, rows);
        this.copy.draw(renderer);
    }

    private setCommon(
        picture: Picture,
        state: State,
        balls: readonly ToolBall[],
        rect: ViewRect,
    ): void {
        const aspect = rect.width / rect.height;
        const { outside, barrel, fog, fieldOfView, orbit } = state.view;
        const camera = outside ? orbitCamera(state.view) : state.view.camera;
        const frame = frameOf(camera);
        const field = outside ? kOutsideField : fieldOfView;
        const slope = Math.tan((field * Math.PI) / 360);
        const thin = picture === this.outside || picture === this.blended;
        const seen = thin ? kCatheterPixels / rect.height : 0;
        const isPlain = picture === this.inside && state.look.style === 'plain';
        const reach = isPlain
            ? lampReach(
                  this.volume!.data,
                  camera,
                  fieldOfView,
                  barrel,
                  aspect,
                  surfaceOf(state),
              )
            : 1;
        picture.set({
            eye: vector(camera.eye),
            right: vector(frame.right),
            up: vector(frame.up),
            ahead: vector(frame.forward),
            aspect,
            slope,
            barrel: outside ? 0 : barrel,
            lightReach: reach * kLightReach,
            fogDistance: outside ? 0 : reach * fog,
            iso: state.shared?.iso_hu ?? -500,
            rising: state.shared?.polarity !== 'falling',
            ...this.catheter.uniforms(camera.eye, seen * orbit.distance * slope),
        });
        const catheter = hasVessel(state) && this.catheter.isThere;
        if (!catheter) picture.set({ catheterCount: 0 });
        this.setTools(picture, state, balls, camera.eye);
        if (picture !== this.fluoroscopy)
            picture.define({
                REAL: state.look.style === 'real' && !outside,
                RAW: picture === this.inside && this.rest?.hasRaw === true,
                CATHETER: catheter,
                INSTRUMENTS: picture.uniforms.toolCount!.value > 0,
            });
        if (picture === this.inside && state.look.style === 'real') this.setReal(state, aspect);
    }

    private setTools(picture: Picture, state: State, balls: readonly ToolBall[], eye: Vec3): void {
        // Scenes with a catheter have no endoscope: only its field of view is marked.
        const { camera, outside } = state.view;
        const isSeen = outside && tipIsInScan(state) && !hasVessel(state);
        const scope = isSeen ? [scopeOf(state)] : [];
        const all = [...balls.slice(0, kMaxTools - 1), ...scope];
        picture.set({ toolCount: all.length });
        if (!all.length) return;
        const scale = scaleOf(state.scan.volume);
        const lumen = lumenOf(this.volume!.data, camera, surfaceOf(state), scale);
        const values = <T>(name: string): T[] => picture.uniforms[name]!.value as T[];
        const quadruple = (name: string, i: number, v: Vec3, w: number): void => {
            values<THREE.Vector4>(name)[i]!.set(...v, w);
        };
        const triple = (name: string, i: number, v: Vec3): void => {
            values<THREE.Vector3>(name)[i]!.set(...v);
        };
        all.forEach((ball, i) => {
            const tool = instrumentOf(ball, camera, lumen, eye);
            quadruple('tools', i, ball.centre, ball.radius);
            quadruple('toolBases', i, tool.base, tool.thickness);
            quadruple('toolSides', i, tool.side, tool.angle);
            triple('toolWrists', i, tool.wrist);
            triple('toolAxes', i, tool.axis);
            values<number>('toolKinds')[i] = kKinds[ball.kind];
            values<number>('toolOpacities')[i] =
                picture === this.inside ? headOpacity(ball, eye, state.view.fieldOfView) : 1;
            values<THREE.Vector3>('toolColours')[i]!.copy(ball.own ? kOwnTool : kOtherTool);
        });
    }

    private setReal(state: State, aspect: number): void {
        const { data } = this.volume!;
        const [sx, sy, sz] = data.grid.spacing;
        const spacingMm = Math.cbrt(sx * sy * sz);
        const { camera, fieldOfView, barrel } = state.view;
        const { lining, fieldStop } = state.look;
        const surface = surfaceOf(state);
        this.inside.set({
            ...liningUniforms(liningOf(lining, surface.rising)),
            exposure: meteredExposure(
                data,
                camera,
                fieldOfView,
                barrel,
                aspect,
                surface,
                fieldStop,
            ),
            spacingMm,
            voxelMm: Math.min(Math.max(spacingMm, 0.4), 1.2),
            fieldStop: kFieldStops.indexOf(fieldStop),
        });
    }

    private drawFluoroscopy(
        renderer: THREE.WebGLRenderer,
        state: State,
        { width, height }: ViewRect,
        seed: number,
    ): void {
        const { data } = this.volume!;
        const camera = orbitCamera(state.view);
        const { contrast, exposure, field, noise } = state.fluoro;
        const usual = usualWater(data, camera, kOutsideField, width / height);
        const { slab, margin } = projectionOf(data.grid, camera);
        this.fluoroscopy.set({
            contrast,
            exposure: usual + Math.log(exposure) / (kWaterPerMm * contrast),
            slab: new THREE.Vector2(...slab),
            margin: new THREE.Vector3(...margin),
            fieldStop: kFieldStops.indexOf(field),
            noise,
            seed,
            pixels: new THREE.Vector2(width, height),
        });
        renderer.clear(true, true, false);
        this.fluoroscopy.draw(renderer);
    }

    private drawBlended(
        renderer: THREE.WebGLRenderer,
        state: State,
        moving: boolean,
        pass: number | undefined,
    ): void {
        const { grid } = this.volume!.data;
        const phase = (pass ?? 0) / kPasses.length;
        this.blended.set(transferUniforms(state, grid, moving, phase));
        renderer.clear(true, true, false);
        this.blended.draw(renderer);
    }

    private clipFromWorld(): THREE.Matrix4 {
        const { projectionMatrix, matrixWorldInverse } = this.lens;
        return new THREE.Matrix4().multiplyMatrices(projectionMatrix, matrixWorldInverse);
    }

    /// Camera of the meshes, with the rays' offset.
    private aimLens(state: State, aspect: number, jitter: THREE.Vector2): void {
        const camera = orbitCamera(state.view);
        const { centre, distance } = state.view.orbit;
        this.lens.aspect = aspect;
        this.lens.near = Math.max(distance * 0.02, 0.5);
        this.lens.far = distance * 20;
        this.lens.position.set(...camera.eye);
        this.lens.up.set(...frameOf(camera).up);
        this.lens.lookAt(vector(centre));
        this.lens.updateProjectionMatrix();
        this.lens.projectionMatrix.elements[8] += jitter.x;
        this.lens.projectionMatrix.elements[9] += jitter.y;
        this.lens.updateMatrixWorld();
    }

    private drawOutside(
        renderer: THREE.WebGLRenderer,
        state: State,
        aspect: number,
        jitter: THREE.Vector2,
    ): void {
        const viewer = orbitCamera(state.view);
        const isCut = tipIsInScan(state);
        this.aimLens(state, aspect, jitter);
        this.outside.set({
            cutPlace: vector(isCut ? state.view.camera.eye : viewer.eye),
            cutNormal: vector(mul(-1, viewer.look)), // towards the viewer
            window: state.sections.window,
            level: state.sections.level,
            clipFromWorld: this.clipFromWorld(),
        });
        renderer.clear(true, true, false);
        this.outside.draw(renderer);
        const eye = this.outside.uniforms.eye!.value as THREE.Vector3;
        if (hasVessel(state)) this.vessel.draw(renderer, eye, this.clipFromWorld());
        if (!isCut) return;
        placeSight(this.body, state.view);
        renderer.render(this.body, this.lens);
    }
}

/// The own endoscope as a tool, for the outside view.
const scopeOf = ({ view: { camera }, flight: { tip } }: State): ToolBall => ({
    centre: camera.eye,
    radius: tip,
    own: true,
    kind: 'scope',
    direction: frameOf(camera).forward,
});

/// Field of view of the endoscope: a cone along +y from the tip at the origin.
function makeSight(): THREE.Scene {
    const scene = new THREE.Scene();
    const sight = new THREE.Mesh(
        new THREE.ConeGeometry(1, 1, 32, 1, true),
        new THREE.MeshBasicMaterial({
            color: 0xffe9a8,
            transparent: true,
            opacity: 0.3,
            side: THREE.DoubleSide,
            depthTest: false, // a mark in front of everything
            depthWrite: false,
        }),
    );
    sight.name = 'sight';
    scene.add(sight);
    return scene;
}

function placeSight(scene: THREE.Scene, { camera, fieldOfView }: View): void {
    const sight = scene.getObjectByName('sight')!;
    const { forward } = frameOf(camera);
    const reach = 12;
    const wide = reach * Math.tan((Math.min(fieldOfView, 110) * Math.PI) / 360);
    // The apex is at the tip; cones of three.js point along +y.
    sight.quaternion.setFromUnitVectors(new THREE.Vector3(0, -1, 0), vector(forward));
    sight.position.set(...along(camera.eye, reach / 2, forward));
    sight.scale.set(wide, reach, wide);
}
