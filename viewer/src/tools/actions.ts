// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What users can do that is neither a drag nor a slider; keys, buttons and wheels call these.

import { worldBounds } from '../maths/grid.ts';
import { readPath } from '../maths/path.ts';
import { frameOf } from '../maths/rays.ts';
import { add, along, dot, mul, sub, type Vec3 } from '../maths/vec.ts';
import { kOverlays } from '../net/protocol.ts';
import { kKinds, rangeOf } from '../state/overlay_kinds.ts';
import {
    kViews,
    kWalls,
    pushOrSlide,
    type SectionName,
    type State,
    type ViewName,
} from '../state/store.ts';
import { keptInside, kSectionAxes, sectionPlane } from '../views/section_geometry.ts';
import { Movie } from './movie.ts';
import { PathTool } from './path_tool.ts';
import type { Session } from './session.ts';
import { kLeastCarving, newStroke } from './strokes.ts';

const clamp = (x: number, low: number, high: number): number => Math.min(Math.max(x, low), high);

export class Actions {
    readonly way: PathTool;
    readonly movie: Movie;

    constructor(private readonly session: Session) {
        const save = (blob: Blob, name: string): void => download(URL.createObjectURL(blob), name);
        this.way = new PathTool(session, save);
        this.movie = new Movie(session, (iso_hu) => this.iso({ iso_hu }), save);
    }

    private get state(): Readonly<State> {
        return this.session.store.state;
    }
    private set(patch: Partial<State>): void {
        this.session.store.set(patch);
    }

    // --- sections

    setCursor(place: Vec3): void {
        const { volume } = this.session;
        if (volume) this.set({ cursor: keptInside(volume.grid, place) });
    }

    /// Whole voxels along a section's normal; up is towards head, left or back.
    scroll(view: SectionName, slices: number): void {
        const { volume } = this.session;
        if (!volume) return;
        const { normal } = kSectionAxes[view];
        const { low, high } = worldBounds(volume.grid);
        // The thinnest way through voxels along the normal, whatever the grid's direction.
        const spacing = volume.grid.spacing.map(
            (s, a) => s * Math.abs(dotColumn(volume, a, normal)),
        );
        const step = Math.max(...spacing);
        const most = dot(sub(high, low), normal) / step;
        this.session.history.step('scroll', () =>
            this.setCursor(along(this.state.cursor, clamp(slices, -most, most) * step, normal)),
        );
    }

    pan(view: SectionName, dx: number, dy: number, width: number, height: number): void {
        const { volume } = this.session;
        if (!volume) return;
        const frame = this.state.sections[view];
        const plane = sectionPlane(volume.grid, view, frame, this.state.cursor, width, height);
        const shift = [
            frame.shift[0] - dx * plane.mmPerPixel,
            frame.shift[1] + dy * plane.mmPerPixel,
        ] as const;
        this.set({ sections: { ...this.state.sections, [view]: { ...frame, shift } } });
    }

    zoom(view: ViewName, factor: number): void {
        if (view === 'endoscope') {
            if (this.state.outside) {
                const { orbit } = this.state;
                this.set({
                    orbit: { ...orbit, distance: clamp(orbit.distance / factor, 20, 5000) },
                });
            } else this.set({ fieldOfView: clamp(this.state.fieldOfView / factor, 30, 120) });
            return;
        }
        const frame = this.state.sections[view];
        const zoom = clamp(frame.zoom * factor, 0.5, 20);
        this.set({ sections: { ...this.state.sections, [view]: { ...frame, zoom } } });
    }

    windowBy(dWindow: number, dLevel: number): void {
        this.set({
            window: clamp(this.state.window + dWindow, 1, 8000),
            level: clamp(this.state.level + dLevel, -2000, 4000),
        });
    }

    /// All sections show the whole volume again.
    fit(): void {
        const whole = { shift: [0, 0] as const, zoom: 1 };
        this.session.history.step('fit', () =>
            this.set({ sections: { axial: whole, coronal: whole, sagittal: whole } }),
        );
    }

    /// The next overlay; none after the last.
    cycleOverlay(): void {
        if (!this.state.features.includes('overlay')) {
            this.session.say('this server has no overlays');
            return;
        }
        const next = kOverlays[(kOverlays.indexOf(this.state.overlay) + 1) % kOverlays.length]!;
        this.set({ overlay: next });
        this.session.say(next === 'none' ? 'no overlay' : kKinds[next].title);
    }

    /// The range stays as it is now, or follows the values.
    fixOverlayRange(fixed: boolean): void {
        const { overlay } = this.state;
        if (fixed && overlay !== 'none') {
            const { reachKey, rest } = kKinds[overlay];
            this.set({ [reachKey]: rangeOf(this.state).high - rest });
        }
        this.set({ overlayAuto: !fixed });
    }

    // --- views

    maximise(view: ViewName | null): void {
        this.set({ maximised: view, ...(view ? { active: view } : {}) });
    }
    toggleMaximised(view: ViewName): void {
        this.maximise(this.state.maximised === view ? null : view);
    }
    cycleViews(): void {
        const order: (ViewName | null)[] = [null, ...kViews];
        const next = order[(order.indexOf(this.state.maximised) + 1) % order.length]!;
        this.maximise(next);
    }

    toggleOutside(): void {
        const { outside, fluoroscopy } = this.state;
        const next = fluoroscopy || !outside;
        this.session.history.step('outside', () => this.set({ outside: next, fluoroscopy: false }));
    }

    toggleFluoroscopy(): void {
        const fluoroscopy = !(this.state.fluoroscopy && this.state.outside);
        this.session.history.step('fluoroscopy', () =>
            this.set({ fluoroscopy, outside: fluoroscopy }),
        );
    }

    /// The outside view from a direction.
    standardView(direction: Vec3, up: Vec3): void {
        this.session.history.step('standard view', () =>
            this.set({
                outside: true,
                orbit: { ...this.state.orbit, direction, up },
                ...(this.state.maximised && this.state.maximised !== 'endoscope'
                    ? { maximised: null }
                    : {}),
            }),
        );
    }

    cycleWall(): void {
        const next = kWalls[(kWalls.indexOf(this.state.wall) + 1) % kWalls.length]!;
        this.setWall(next);
    }
    setWall(wall: State['wall']): void {
        if (this.state.wall === 'push' && wall !== 'push') void this.session.ask({ do: 'release' });
        this.set({ wall });
    }

    // --- tissue

    /// The tool at the crosshair, for those who use no mouse.
    async applyAtCursor(): Promise<void> {
        const { tool, cursor, radius, strength, active, depth, slide } = this.state;
        const { right, ahead } = this.frameOfActive();
        if (tool === 'push')
            await this.session.ask({
                do: pushOrSlide(this.state, slide),
                point: cursor,
                push: mul(strength * (radius || 1), active === 'endoscope' ? ahead : right),
                radius,
            });
        else if (tool === 'carve')
            await this.session.ask({
                do: 'carve',
                from: cursor,
                to: cursor,
                radius: Math.max(radius, kLeastCarving),
            });
        else if (tool === 'cut')
            await this.session.ask({
                do: 'cut',
                line: [-2, 2].map((s) =>
                    along(along(cursor, s * radius, right), -depth / 2, ahead),
                ),
                depth: mul(depth, ahead),
            });
        else if (tool === 'grab') await this.nudge([0, radius / 2]);
        else if (tool === 'path') await this.way.click(cursor);
        else this.session.say('choose push, grab, cut or carve first');
    }

    /// Grabs at the crosshair and leads it by millimetres right and up in the active view.
    async nudge(by: readonly [number, number]): Promise<void> {
        const { cursor, radius } = this.state;
        const { right, up } = this.frameOfActive();
        const motion = add(mul(by[0], right), mul(by[1], up));
        if (this.state.tool === 'grab') {
            if (!(await this.session.ask({ do: 'grab', point: cursor, radius }))) return;
            await this.session.ask({ do: 'drag', offset: motion });
            await this.session.ask({ do: 'let_go' });
        } else {
            const stroke = newStroke();
            await this.session.ask({ do: 'push', point: cursor, push: motion, radius, stroke });
        }
        this.setCursor(add(cursor, motion));
    }

    private frameOfActive(): { right: Vec3; up: Vec3; ahead: Vec3 } {
        const { active, camera } = this.state;
        if (active !== 'endoscope') {
            const { right, up, normal } = kSectionAxes[active];
            return { right, up, ahead: normal };
        }
        const { right, up, forward } = frameOf(camera);
        return { right, up, ahead: forward };
    }

    relax(): void {
        void this.session.ask({ do: 'relax', on: !this.state.shared?.relaxing });
    }

    // --- the threshold, which all clients share

    private isoWish: { iso_hu?: number; polarity?: 'rising' | 'falling' } | undefined;
    private isoSent: number | undefined;
    private isoBusy = false;

    /// Asks for a threshold; while one is under way only the newest wish is kept.
    iso(wish: { iso_hu?: number; polarity?: 'rising' | 'falling' }): void {
        this.isoWish = { ...this.isoWish, ...wish };
        if (!this.isoBusy) void this.sendIso();
    }

    /// The threshold that has been asked for or, without a wish, the one that holds.
    get wantedIso(): number {
        return this.isoWish?.iso_hu ?? this.isoSent ?? this.state.shared?.iso_hu ?? -500;
    }

    private async sendIso(): Promise<void> {
        this.isoBusy = true;
        while (this.isoWish) {
            const wish = this.isoWish;
            this.isoWish = undefined;
            this.isoSent = wish.iso_hu;
            await this.session.ask({ do: 'iso', ...wish });
        }
        this.isoSent = undefined;
        this.isoBusy = false;
    }

    // --- files

    /// What was dropped on the page or chosen: a path, or keyframes.
    async openFile(file: File): Promise<void> {
        try {
            const text = await file.text();
            if (this.movie.open(text, file.name)) return;
            this.session.setPath(readPath(text, file.name));
            this.session.say(`${file.name}: a path; Fly it in the panel Endoscope`);
        } catch (error) {
            this.session.say((error as Error).message);
        }
    }

    async snapshot(): Promise<void> {
        const blob = await this.session.stage.toBlob();
        if (blob) download(URL.createObjectURL(blob), 'pliant.png');
    }
}

const dotColumn = (
    volume: { grid: { direction: readonly Vec3[] } },
    axis: number,
    normal: Vec3,
): number => dot(volume.grid.direction[axis]!, normal);

export function download(url: string, name: string): void {
    const link = document.createElement('a');
    link.href = url;
    link.download = name;
    link.click();
}
