// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Canvas behind the four views. A view is drawn only after a change of its contents; the others
// keep their pixels. While something moves, the endoscope's picture is drawn with fewer pixels,
// adapted to the last frame times; when all is still, it is drawn once more in full. A frame begins
// when the graphics processor has finished the previous one, so that frames never queue up. The
// first picture of a scan, and of each kind of picture, has a third of the resolution, since the
// machine's speed is unknown. A slow machine draws a full picture in bands, one per frame, so that
// it follows a change at once.

import * as THREE from 'three';
import type { VolumeData } from '../maths/volume.ts';
import type { Vessel } from '../net/vessel.ts';
import { kViews, type SectionName, type State, type ViewName } from '../state/state.ts';
import type { Store } from '../state/store.ts';
import { EndoscopeView, kPasses } from './endoscope_view.ts';
import type { ToolBall } from './instruments.ts';
import { kNoLabels, LabelColours, type LabelField } from './label_field.ts';
import type { OverlayField } from './overlay_field.ts';
import { fieldUniforms, kNoField, overlayUniforms, Picture, type ViewRect } from './picture.ts';
import { planesOf } from './planes.ts';
import type { RestField } from './rest_field.ts';
import { sectionPlane } from './section_geometry.ts';
import { kSection } from './shaders.ts';
import { kNoSlab, slabUniforms } from './volume_view.ts';
import { VolumeTexture } from './volume_texture.ts';

const kScales = [1, 0.66, 0.5, 0.35, 0.25];
const kFirstQuality = 3; // index of kScales for the first picture
const kSlowMs = 45; // frame time above which pixels are reduced
const kQuickMs = 22; // frame time below which pixels are increased
const kBands = 8; // of a full picture
const kStillMs = 180; // time without a change before the full picture

/// Groups of the state that the views depend on, apart from the threshold and the cut face.
const inAllViews = ({ scan, overlay, labels, display }: State): unknown[] => [
    scan.volume,
    scan.voxels,
    scan.overlay,
    scan.extreme,
    scan.loaded === 1,
    overlay,
    labels,
    display,
];
const inEndoscope = (state: State): unknown[] => {
    const { view, look, fluoro, rendering, flight, versions, hands } = state;
    return [...inAllViews(state), view, look, fluoro, rendering, flight, versions, hands];
};
const inSections = (state: State): unknown[] => [...inAllViews(state), state.sections];

/// Kind of the endoscope's picture: each has a speed of its own.
const kindOf = ({ view, look }: State): string =>
    view.outside ? `${view.fluoroscopy} ${view.blended}` : look.style;

const differ = (a: readonly unknown[], b: readonly unknown[]): boolean =>
    a.some((part, i) => part !== b[i]);

export interface StageHooks {
    /// Position of a view on the page.
    rectOf(view: ViewName): DOMRect;
    /// The graphics context was lost or restored.
    onContext(lost: boolean): void;
    /// Frames are too slow even with the fewest pixels.
    onTooSlow(): void;
}

export class Stage {
    readonly renderer: THREE.WebGLRenderer;
    texture: VolumeTexture | undefined;
    overlay: OverlayField | undefined;
    rest: RestField | undefined;
    labels: LabelField | undefined;
    vessel: Vessel | undefined;
    /// Mean time of the graphics processor for a frame in motion [ms].
    frameMs = 0;
    framesDrawn = 0;
    private readonly endoscope = new EndoscopeView();
    private readonly labelColours = new LabelColours();
    private readonly section = new Picture(kSection, {
        ...kNoField,
        ...kNoLabels,
        ...kNoSlab,
        centre: new THREE.Vector3(),
        right: new THREE.Vector3(),
        up: new THREE.Vector3(),
        halfExtent: new THREE.Vector2(),
        window: 1,
        level: 0,
        contour: false,
        pixel: 1,
    });
    private readonly stale = new Set<ViewName>(kViews);
    private quality = kFirstQuality; // index of kScales
    private lastChange = 0;
    private fence: WebGLSync | null = null;
    private fenceStart = 0;
    private fenceMoving = false; // the frame was drawn in motion
    private full = false; // the endoscope's picture is complete
    private first = true; // no picture of this scan was drawn
    private coarse: VolumeTexture | undefined; // shown until the scan is complete
    private blank = true; // gaps between the views may hold old pixels
    private prepared = false; // programs for instruments are compiled
    private pass = 0; // next index of kPasses while all is still
    private row = 0; // next row of the pass, from above
    private lost = false;
    balls: readonly ToolBall[] = [];

    constructor(
        private readonly canvas: HTMLCanvasElement,
        private readonly store: Store,
        private readonly hooks: StageHooks,
    ) {
        this.renderer = new THREE.WebGLRenderer({
            canvas,
            antialias: false,
            alpha: false,
            preserveDrawingBuffer: true,
            powerPreference: 'high-performance',
        });
        this.renderer.autoClear = false;
        this.renderer.setScissorTest(true);
        store.listen((state, before) => this.noteChange(state, before));
        canvas.addEventListener('webglcontextlost', () => {
            this.lost = true;
            this.fence = null; // fences of a lost context are never signalled
            // three.js would delete stale handles later, in the new context.
            this.endoscope.dispose();
            for (const field of this.fields) field?.dispose();
            this.labelColours.dispose();
            hooks.onContext(true);
        });
        canvas.addEventListener('webglcontextrestored', () => {
            this.lost = false;
            this.renderer.setScissorTest(true);
            for (const field of this.fields) field?.restore();
            this.invalidate();
            hooks.onContext(false);
        });
        new ResizeObserver(() => this.invalidate()).observe(canvas);
    }

    setVolume(data: VolumeData): void {
        this.coarse?.dispose();
        this.coarse = undefined;
        this.texture?.dispose();
        this.texture = new VolumeTexture(data);
        this.show(this.texture);
    }

    /// Shows a coarse scan until the scan itself is complete.
    setCoarse(data: VolumeData): void {
        this.coarse?.dispose();
        this.coarse = new VolumeTexture(data);
        if (!this.lost) this.texture?.reserve(this.renderer);
        this.show(this.coarse);
    }

    private show(texture: VolumeTexture): void {
        this.endoscope.setVolume(texture);
        this.section.set(fieldUniforms(texture));
        this.first = true;
        this.invalidate();
    }

    private get fields(): ({ dispose(): void; restore(): void } | undefined)[] {
        return [this.texture, this.coarse, this.overlay, this.rest, this.labels];
    }

    setOverlay(field: OverlayField | undefined): void {
        this.overlay?.dispose();
        this.overlay = field;
        this.invalidate();
    }

    setRest(field: RestField | undefined): void {
        if (field === this.rest) return;
        this.rest?.dispose();
        this.rest = field;
        this.endoscope.setRest(field);
        this.markEndoscope();
    }

    setLabels(field: LabelField | undefined): void {
        this.labels?.dispose();
        this.labels = field;
        this.invalidate();
    }

    setTools(balls: readonly ToolBall[]): void {
        if (!balls.length && !this.balls.length) return;
        this.balls = balls;
        this.markEndoscope();
    }

    invalidate(): void {
        this.blank = true;
        for (const view of kViews) this.stale.add(view);
        this.beginPicture();
    }

    private beginPicture(): void {
        this.full = false;
        this.pass = 0;
        this.row = 0;
        this.lastChange = performance.now();
    }

    /// Tests whether all views are drawn completely.
    get isStill(): boolean {
        const isCoarse = this.coarse !== undefined && this.store.state.scan.loaded === 1;
        return this.full && !this.stale.size && !this.fence && !isCoarse;
    }

    /// Draws the stale views. @returns whether anything was drawn
    frame(now: number): boolean {
        const { state } = this.store;
        if (this.lost || !this.texture || !this.lastIsDone(now)) return false;
        if (state.scan.loaded === 1 && this.coarse) {
            this.coarse.dispose();
            this.coarse = undefined;
            this.show(this.texture);
        }
        if (state.scan.loaded < 1 && !this.coarse) return false;
        this.fitCanvas();
        this.coarse?.upload(this.renderer);
        this.texture.upload(this.renderer);
        this.overlay?.upload(this.renderer);
        this.rest?.upload(this.renderer);
        this.labels?.upload(this.renderer);
        const still = now - this.lastChange > kStillMs && !this.first;
        const { maximised } = state.display;
        if (maximised && maximised !== 'endoscope') this.full = true; // hidden
        if (this.coarse) this.full = true; // its voxels are on their way
        if (still && !this.full) this.stale.add('endoscope');
        if (!this.stale.size) return this.prepare();
        if (this.blank) this.clear();
        for (const view of this.stale) this.drawView(view, state, still);
        // The first frame compiles shaders: its time says nothing about the next.
        this.fenceMoving = !still && this.stale.has('endoscope') && this.framesDrawn > 0;
        this.stale.clear();
        this.first = false;
        this.raiseFence(now);
        ++this.framesDrawn;
        return true;
    }

    private clear(): void {
        const { width, height } = this.canvas;
        this.renderer.setViewport(0, 0, width, height);
        this.renderer.setScissor(0, 0, width, height);
        this.renderer.clear();
        this.blank = false;
    }

    /// Compiles programs for instruments once, when nothing else is to be drawn.
    private prepare(): boolean {
        if (this.prepared || !this.full) return false;
        this.prepared = true;
        this.endoscope.prepareInstruments(this.renderer);
        this.fenceMoving = false;
        this.raiseFence(performance.now());
        return false;
    }

    private raiseFence(now: number): void {
        const gl = this.renderer.getContext() as WebGL2RenderingContext;
        this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
        this.fenceStart = now;
        gl.flush();
    }

    private lastIsDone(now: number): boolean {
        if (!this.fence) return true;
        const gl = this.renderer.getContext() as WebGL2RenderingContext;
        if (gl.getSyncParameter(this.fence, gl.SYNC_STATUS) !== gl.SIGNALED) return false;
        gl.deleteSync(this.fence);
        this.fence = null;
        if (this.fenceMoving) this.adapt(now - this.fenceStart);
        return true;
    }

    /// Copies the pictures. @param draw  draws over them; ratio: pixels per CSS pixel
    async copy(
        draw: (context: CanvasRenderingContext2D, ratio: number) => Promise<void>,
    ): Promise<HTMLCanvasElement> {
        const copy = document.createElement('canvas');
        copy.width = this.canvas.width;
        copy.height = this.canvas.height;
        const context = copy.getContext('2d')!;
        context.drawImage(this.canvas, 0, 0);
        await draw(context, copy.width / this.canvas.getBoundingClientRect().width);
        return copy;
    }

    private noteChange(state: State, before: State): void {
        const wall =
            state.shared?.iso_hu !== before.shared?.iso_hu ||
            state.shared?.polarity !== before.shared?.polarity;
        if (kindOf(state) !== kindOf(before)) {
            this.quality = Math.max(this.quality, kFirstQuality);
            this.frameMs = 0;
        }
        const { sections: now, view } = state;
        const then = before.sections;
        if (state.display.maximised !== before.display.maximised) this.blank = true;
        const cutFace = view.outside && (now.window !== then.window || now.level !== then.level);
        if (wall || cutFace || differ(inEndoscope(state), inEndoscope(before)))
            this.markEndoscope();
        if (wall || differ(inSections(state), inSections(before)))
            for (const name of kViews.slice(1)) this.stale.add(name);
    }

    private markEndoscope(): void {
        this.stale.add('endoscope');
        this.beginPicture();
    }

    private fitCanvas(): void {
        const ratio = Math.min(window.devicePixelRatio || 1, 2);
        const box = this.canvas.getBoundingClientRect();
        const width = Math.max(Math.round(box.width * ratio), 1);
        const height = Math.max(Math.round(box.height * ratio), 1);
        if (this.canvas.width === width && this.canvas.height === height) return;
        this.renderer.setPixelRatio(1);
        this.renderer.setSize(width, height, false);
        this.invalidate();
    }

    private adapt(frameMs: number): void {
        this.frameMs = this.frameMs ? 0.7 * this.frameMs + 0.3 * frameMs : frameMs;
        const slow = this.frameMs > kSlowMs && this.quality + 1 < kScales.length;
        if (this.frameMs > kSlowMs && !slow) this.hooks.onTooSlow();
        const quick = this.frameMs < kQuickMs && this.quality > 0;
        if (!slow && !quick) return;
        this.quality += slow ? 1 : -1;
        this.frameMs = 0; // unknown for the new size
    }

    private drawView(view: ViewName, state: State, still: boolean): void {
        const { maximised, fine } = state.display;
        if (maximised && maximised !== view) return;
        const rect = this.pixelRect(view);
        if (rect.width < 1 || rect.height < 1) return;
        if (view === 'endoscope') {
            // Four rays per pixel: at once where pixels are cheap, else in successive passes.
            const cheap = this.quality === 0;
            const scale = still ? (fine && cheap ? 2 : 1) : kScales[this.quality]!;
            const { outside, fluoroscopy } = state.view;
            const passes = still && fine && !cheap && !(outside && fluoroscopy);
            this.endoscope.setOverlay(state, this.overlay);
            this.endoscope.setLabels(this.labels && this.labelColours.uniforms(state, this.labels));
            this.endoscope.setVessel(this.vessel, state.versions.vessel);
            const pass = passes ? this.pass : undefined;
            const left = rect.height - this.row;
            const rows = passes ? Math.min(Math.ceil(rect.height / kBands), left) : rect.height;
            const band = passes ? { from: left - rows, rows } : undefined;
            const seed = still ? 0 : this.framesDrawn; // a still picture doesn't flicker
            const { renderer, balls } = this;
            planesOf(state, rect).forEach(({ view: seen, x, y, width, height }, n) => {
                const part = {
                    x: rect.x + x,
                    y: rect.y + rect.height - y - height,
                    width,
                    height,
                };
                const shown = { ...state, view: seen };
                const more = { seed: seed + n, pass, band, moving: !still };
                this.endoscope.draw(renderer, shown, balls, part, scale, more);
            });
            if (passes && rows === left) {
                this.row = 0;
                ++this.pass;
            } else if (passes) this.row += rows;
            this.full = still && (!passes || this.pass === kPasses.length);
        } else this.drawSection(view, state, rect);
    }

    private drawSection(view: SectionName, state: State, rect: ViewRect): void {
        const { grid } = this.texture!.data;
        const { frames, cursor, window, level } = state.sections;
        const plane = sectionPlane(grid, view, frames[view], cursor, rect.width, rect.height);
        this.section.set(overlayUniforms(state, this.overlay));
        if (this.labels) this.section.set(this.labelColours.uniforms(state, this.labels));
        this.section.define({ LABELS: this.labels !== undefined });
        this.section.set(slabUniforms(state.sections, grid, plane));
        this.section.set({
            centre: new THREE.Vector3(...plane.centre),
            right: new THREE.Vector3(...plane.axes.right),
            up: new THREE.Vector3(...plane.axes.up),
            halfExtent: new THREE.Vector2(
                0.5 * rect.width * plane.mmPerPixel,
                0.5 * rect.height * plane.mmPerPixel,
            ),
            window,
            level,
            iso: state.shared?.iso_hu ?? 0,
            contour: state.display.contour,
            pixel: plane.mmPerPixel,
        });
        this.renderer.setViewport(rect.x, rect.y, rect.width, rect.height);
        this.renderer.setScissor(rect.x, rect.y, rect.width, rect.height);
        this.section.draw(this.renderer);
    }

    private pixelRect(view: ViewName): ViewRect {
        const box = this.canvas.getBoundingClientRect();
        const rect = this.hooks.rectOf(view);
        const ratio = this.canvas.width / box.width;
        const left = Math.round((rect.left - box.left) * ratio);
        const right = Math.round((rect.right - box.left) * ratio);
        const top = Math.round((rect.top - box.top) * ratio);
        const bottom = Math.round((rect.bottom - box.top) * ratio);
        return {
            x: left,
            y: this.canvas.height - bottom,
            width: right - left,
            height: bottom - top,
        };
    }
}
