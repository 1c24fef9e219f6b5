// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Actions of keys, buttons and wheels: everything but drags and sliders.

import { closingThreshold } from '../maths/closing.ts';
import { voxelFromWorld, worldBounds } from '../maths/grid.ts';
import { alongLumen, freePlace } from '../maths/flight.ts';
import { isMarkTable, isPathFile } from '../maths/marks_file.ts';
import { readPath } from '../maths/path.ts';
import { frameOf } from '../maths/rays.ts';
import { add, along, dot, mul, norm, sub, type Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';
import { kOverlays } from '../net/protocol.ts';
import { kWatched } from '../state/company.ts';
import { kKinds, rangeOf } from '../state/overlay_kinds.ts';
import {
    kViewing,
    kProjections,
    kViews,
    kWalls,
    offersVessel,
    pushOrSlide,
    type SectionName,
    type State,
    suits,
    type ToolName,
    type ViewName,
    type Wall,
} from '../state/state.ts';
import type { Patch } from '../state/store.ts';
import {
    lengthFor,
    levelReach,
    scaleOf,
    spanOfValues,
    textWithUnit,
    valueScale,
    volumeText,
} from '../state/units.ts';
import { keptInside, kSectionAxes, sectionPlane } from '../views/section_geometry.ts';
import { hasTwoPlanes } from '../views/planes.ts';
import type { Stage } from '../views/stage.ts';
import { saveBlob } from './download.ts';
import type { Session } from './session.ts';
import { carvingRadius, newStroke } from './strokes.ts';

// Lengths in a body.
const kBeside = 8; // distance to a lumen [mm]
const kUsualSlab = 10; // [mm]
const kNearest = 20; // distance of the view from outside [mm]
const kFarthest = 5000;

/// Answer to a tool that the tissue doesn't take.
export const kUnsuited = 'this tissue does not take this tool';

const isTable = (name: string): boolean => /\.(csv|ctbl)$/i.test(name);
const clamp = (x: number, low: number, high: number): number => Math.min(Math.max(x, low), high);

export class Actions {
    constructor(private readonly session: Session) {}

    private get state(): State {
        return this.session.store.state;
    }
    /// Length scale of the scan; 1 for a patient.
    private get scale(): number {
        return scaleOf(this.state.scan.volume);
    }
    private set(patch: Patch): void {
        this.session.store.set(patch);
    }

    // --- sections

    setCursor(place: Vec3): void {
        const { volume } = this.session;
        if (volume) this.set({ sections: { cursor: keptInside(volume.grid, place) } });
    }

    /// Scrolls by whole voxels along a section's normal; up is towards head, left or back.
    scroll(view: SectionName, slices: number): void {
        const { volume } = this.session;
        if (!volume) return;
        const { normal } = kSectionAxes[view];
        const { low, high } = worldBounds(volume.grid);
        // Spacing along the normal, for oblique grids as well.
        const spacing = volume.grid.spacing.map(
            (s, a) => s * Math.abs(dotColumn(volume, a, normal)),
        );
        const step = Math.max(...spacing);
        const most = dot(sub(high, low), normal) / step;
        const { cursor } = this.state.sections;
        this.session.history.step('scroll', () =>
            this.setCursor(along(cursor, clamp(slices, -most, most) * step, normal)),
        );
    }

    pan(view: SectionName, dx: number, dy: number, width: number, height: number): void {
        const { volume } = this.session;
        if (!volume) return;
        const { frames, cursor } = this.state.sections;
        const frame = frames[view];
        const plane = sectionPlane(volume.grid, view, frame, cursor, width, height);
        const shift = [
            frame.shift[0] - dx * plane.mmPerPixel,
            frame.shift[1] + dy * plane.mmPerPixel,
        ] as const;
        this.set({ sections: { frames: { ...frames, [view]: { ...frame, shift } } } });
    }

    /// Zooms a view. @param fixed  point that stays where it is in a section [mm, LPS]
    zoom(view: ViewName, factor: number, fixed?: Vec3): void {
        if (view === 'endoscope') {
            const { outside, orbit, fieldOfView } = this.state.view;
            const { scale } = this;
            const away = orbit.distance / factor;
            const distance = clamp(away, scale * kNearest, scale * kFarthest);
            if (outside) this.set({ view: { orbit: { ...orbit, distance } } });
            else this.set({ view: { fieldOfView: clamp(fieldOfView / factor, 30, 120) } });
            return;
        }
        const { frames } = this.state.sections;
        const { volume } = this.session;
        const { zoom: before, shift } = frames[view];
        const zoom = clamp(before * factor, 0.5, 20);
        const middle = volume && add(...halves(volume));
        const share = 1 - before / zoom;
        const { right, up } = kSectionAxes[view];
        const moved = (axis: Vec3, from: number): number =>
            fixed && middle ? from + share * (dot(sub(fixed, middle), axis) - from) : from;
        const frame = { zoom, shift: [moved(right, shift[0]), moved(up, shift[1])] as const };
        this.set({ sections: { frames: { ...frames, [view]: frame } } });
    }

    /// Changes window and level [HU, or the same share of the scan's range].
    windowBy(dWindow: number, dLevel: number): void {
        const { sections, scan } = this.state;
        const unit = valueScale(scan.volume);
        const { low, high } = levelReach(scan.volume);
        this.set({
            sections: {
                window: clamp(sections.window + unit * dWindow, unit, 8000 * unit),
                level: clamp(sections.level + unit * dLevel, low, high),
            },
        });
    }

    /// Switches the sections to the next projection of a slab; to planes after the last.
    cycleSlab(): void {
        const { slab, projection } = this.state.sections;
        const next = slab > 0 ? kProjections.indexOf(projection) + 1 : 0;
        const ends = next === kProjections.length;
        this.session.history.step('slab', () =>
            this.set({
                sections: ends
                    ? { slab: 0 }
                    : {
                          slab: slab || lengthFor(this.state.scan.volume, kUsualSlab, 0.5),
                          projection: kProjections[next]!,
                      },
            }),
        );
    }

    /// Shows the whole volume in all sections.
    fit(): void {
        const whole = { shift: [0, 0] as const, zoom: 1 };
        this.session.history.step('fit', () =>
            this.set({ sections: { frames: { axial: whole, coronal: whole, sagittal: whole } } }),
        );
    }

    /// Switches to the next overlay; to none after the last.
    cycleOverlay(): void {
        if (!this.state.link.features.includes('overlay')) {
            this.session.warn('this server has no overlays');
            return;
        }
        const { kind } = this.state.overlay;
        const next = kOverlays[(kOverlays.indexOf(kind) + 1) % kOverlays.length]!;
        this.set({ overlay: { kind: next } });
        this.session.say(next === 'none' ? 'no overlay' : kKinds[next].title);
    }

    /// Fixes the colours' range as it is now, or lets it follow the values.
    fixOverlayRange(fixed: boolean): void {
        const { kind } = this.state.overlay;
        if (fixed && kind !== 'none') {
            const { reachKey, rest } = kKinds[kind];
            this.set({ overlay: { [reachKey]: rangeOf(this.state).high - rest } });
        }
        this.set({ overlay: { auto: !fixed } });
    }

    // --- views

    maximise(view: ViewName | null): void {
        this.set({ display: { maximised: view }, ...(view ? { pointer: { active: view } } : {}) });
    }
    toggleMaximised(view: ViewName): void {
        this.maximise(this.state.display.maximised === view ? null : view);
    }
    cycleViews(): void {
        const order: (ViewName | null)[] = [null, ...kViews];
        const next = order[(order.indexOf(this.state.display.maximised) + 1) % order.length]!;
        this.maximise(next);
    }

    toggleOutside(): void {
        const { outside, fluoroscopy, blended } = this.state.view;
        const next = fluoroscopy || blended || !outside;
        this.session.history.step('outside', () =>
            this.set({ view: { outside: next, fluoroscopy: false, blended: false } }),
        );
    }

    /// Shows the scan as a volume, from outside.
    toggleBlended(): void {
        const { outside, fluoroscopy, blended } = this.state.view;
        const next = !(outside && blended && !fluoroscopy);
        this.session.history.step('volume rendering', () =>
            this.set({ view: { outside: next, fluoroscopy: false, blended: next } }),
        );
    }

    toggleFluoroscopy(): void {
        const { view } = this.state;
        const fluoroscopy = !(view.fluoroscopy && view.outside);
        this.session.history.step('fluoroscopy', () =>
            this.set({ view: { fluoroscopy, outside: fluoroscopy, blended: false } }),
        );
    }

    /// Shows fluoroscopy in two planes, or without the second.
    toggleBiplane(): void {
        const biplane = !hasTwoPlanes(this.state);
        if (!(this.state.view.fluoroscopy && this.state.view.outside)) this.toggleFluoroscopy();
        this.set({ fluoro: { biplane } });
    }

    /// Shows the outside view from a direction.
    standardView(direction: Vec3, up: Vec3): void {
        const { view, display } = this.state;
        const hidden = display.maximised && display.maximised !== 'endoscope';
        this.session.history.step('standard view', () =>
            this.set({
                view: { outside: true, orbit: { ...view.orbit, direction, up } },
                ...(hidden ? { display: { maximised: null } } : {}),
            }),
        );
    }

    /// Moves the endoscope to a position, or into the lumen beside it. It looks along the lumen.
    endoscopeTo(place: Vec3): void {
        const { session } = this;
        const { volume, surface } = session;
        if (!volume) return;
        const { flight, view } = this.state;
        const eye = freePlace(volume, place, flight.tip, surface, this.scale * kBeside);
        if (!eye) session.warn('there is no lumen here at this threshold');
        session.endoscope.goTo(
            eye ?? place,
            eye ? alongLumen(volume, eye, view.camera.look, surface) : view.camera.look,
        );
        this.set({ view: { outside: false } });
    }

    /// Sets the threshold at which the lumen around the endoscope does not leak through its walls.
    closeWalls(): void {
        const { session } = this;
        const { volume, surface, threshold } = session;
        if (!volume) return;
        const { scan, view } = this.state;
        const at = voxelFromWorld(volume.grid, view.camera.eye);
        const found = closingThreshold(volume, surface, at, spanOfValues(scan.volume));
        if (!found) {
            session.warn('the endoscope is in tissue at this threshold; lead it into a lumen');
            return;
        }
        const size = volumeText(found.voxels * volume.grid.spacing.reduce((p, s) => p * s, 1));
        if (found.threshold === undefined) {
            session.say(
                found.isWhole
                    ? `no leak at this threshold: the lumen around the endoscope holds ${size}`
                    : `no leak found in the first ${size} of the lumen around the endoscope; ` +
                          'more was not looked at',
            );
            return;
        }
        threshold.ask({ iso_hu: found.threshold });
        const value = textWithUnit(scan.volume, found.threshold);
        session.say(`walls closed at ${value}: the lumen around the endoscope holds ${size}`);
    }

    cycleWall(): void {
        const next = kWalls[(kWalls.indexOf(this.state.flight.wall) + 1) % kWalls.length]!;
        this.setWall(next);
    }
    setWall(wall: Wall): void {
        const pushed = this.state.flight.wall === 'push';
        if (pushed && wall !== 'push') void this.session.ask({ do: 'release' });
        this.set({ flight: { wall } });
    }

    // --- tissue

    /// Chooses a tool, unless this client may not use it.
    choose(name: ToolName): void {
        const { link, shared, replay } = this.state;
        if (replay.isOn && !kViewing.includes(name)) this.session.warn(kWatched);
        else if (link.role === 'view' && !kViewing.includes(name))
            this.session.warn('this link is for viewing: it changes no tissue');
        else if (name === 'catheter' && !offersVessel(shared))
            this.session.warn('this scan has no catheter');
        else if (!suits(this.state, name)) this.session.warn(kUnsuited);
        else this.set({ tool: { name } });
    }

    /// Uses the tool at the crosshair, for users without a mouse.
    async applyAtCursor(): Promise<void> {
        const { name, radius, strength, depth, slide } = this.state.tool;
        const { cursor } = this.state.sections;
        const { active } = this.state.pointer;
        const { right, ahead } = this.frameOfActive();
        if (name === 'push') {
            const push = mul(
                strength * (radius || this.scale),
                active === 'endoscope' ? ahead : right,
            );
            await this.session.ask(
                { do: pushOrSlide(this.state, slide), point: cursor, push, radius },
                { from: cursor, by: push, radius },
            );
        } else if (name === 'carve')
            await this.session.ask({
                do: 'carve',
                from: cursor,
                to: cursor,
                radius: carvingRadius(this.state),
            });
        else if (name === 'cut')
            await this.session.ask({
                do: 'cut',
                line: [-2, 2].map((s) =>
                    along(along(cursor, s * radius, right), -depth / 2, ahead),
                ),
                depth: mul(depth, ahead),
            });
        else if (name === 'grab') await this.nudge([0, radius / 2]);
        else if (name === 'path') await this.session.path.click(cursor);
        else if (name === 'measure') this.session.marks.click(cursor);
        else this.session.warn('choose push, grab, cut or carve first');
    }

    /// Grabs or pushes tissue at the crosshair, right and up in the active view [mm].
    async nudge(by: readonly [number, number]): Promise<void> {
        const { name, radius } = this.state.tool;
        const { cursor } = this.state.sections;
        const { right, up } = this.frameOfActive();
        const motion = add(mul(by[0], right), mul(by[1], up));
        if (name === 'grab') {
            if (!(await this.session.ask({ do: 'grab', point: cursor, radius }))) return;
            await this.session.ask({ do: 'drag', offset: motion });
            await this.session.ask({ do: 'let_go' });
        } else {
            const stroke = newStroke();
            await this.session.ask(
                { do: 'push', point: cursor, push: motion, radius, stroke },
                { from: cursor, by: motion, radius },
            );
        }
        this.setCursor(add(cursor, motion));
    }

    private frameOfActive(): { right: Vec3; up: Vec3; ahead: Vec3 } {
        const { active } = this.state.pointer;
        if (active !== 'endoscope') {
            const { right, up, normal } = kSectionAxes[active];
            return { right, up, ahead: normal };
        }
        const { right, up, forward } = frameOf(this.state.view.camera);
        return { right, up, ahead: forward };
    }

    relax(): void {
        const on = !this.state.shared?.relaxing;
        this.session.tissueDefaults.keep({ springsBack: on });
        void this.session.ask({ do: 'relax', on });
    }

    // --- files

    /// Opens a file of a path, of marks, of names of labels, or of keyframes.
    async openFile(file: File): Promise<void> {
        try {
            const text = await file.text();
            if (this.session.movie.open(text, file.name)) return;
            if (isTable(file.name) && !isMarkTable(text)) {
                this.session.labelMap.openNames(text, file.name);
                return;
            }
            if (isTable(file.name) || !isPathFile(text)) {
                this.session.marks.open(text, file.name);
                return;
            }
            const path = readPath(text, file.name);
            const { volume } = this.session;
            const isOutside = (p: Vec3): boolean =>
                norm(sub(keptInside(volume!.grid, p), p)) > this.scale;
            if (volume && path.points.every(isOutside))
                throw new Error(`${file.name}: the path lies outside of this scan`);
            this.session.path.use(path);
            this.session.say(`${file.name}: a path; press Fly in the panel Endoscope`);
        } catch (error) {
            this.session.warn((error as Error).message);
        }
    }

    /// Opens a label map, or names of labels.
    async openLabels(file: File): Promise<void> {
        try {
            const { labelMap } = this.session;
            if (/\.(ctbl|csv|txt)$/i.test(file.name))
                labelMap.openNames(await file.text(), file.name);
            else await labelMap.send(file);
        } catch (error) {
            this.session.say((error as Error).message);
        }
    }

    /// Adds the marks of a file; a curve is a mark here, and no path.
    async openMarks(file: File): Promise<void> {
        try {
            this.session.marks.open(await file.text(), file.name);
        } catch (error) {
            this.session.say((error as Error).message);
        }
    }

    /// Draws the marks over the pictures into a copy of them; set by the page.
    paintMarks: Parameters<Stage['copy']>[0] = async () => {};

    /// Saves a picture of the views with their marks.
    async snapshot(): Promise<void> {
        const { stage } = this.session;
        const canvas = await stage.copy(this.paintMarks);
        const blob = await new Promise<Blob | null>((done) => canvas.toBlob(done, 'image/png'));
        const name = (this.state.scan.volume?.name ?? 'pliant').replace(/[^\w.-]+/g, '_');
        if (blob) saveBlob(blob, `${name.replace(/\.(nrrd|nii|mha|gz|toml)/g, '')}_views.png`);
    }
}

/// Halves of the lowest and highest corner of the scan: their sum is its middle.
const halves = ({ grid }: VolumeData): [Vec3, Vec3] => {
    const { low, high } = worldBounds(grid);
    return [mul(0.5, low), mul(0.5, high)];
};

const dotColumn = (
    volume: { grid: { direction: readonly Vec3[] } },
    axis: number,
    normal: Vec3,
): number => dot(volume.grid.direction[axis]!, normal);
