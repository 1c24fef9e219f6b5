// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Marks over the pictures: names, letters, crosshair, tools, paths. They are HTML and SVG elements:
// sharp, accessible to screen readers, and cheap to update.

import { type Grid, shown, voxelFromWorld } from '../maths/grid.ts';
import { type Camera, firstHit } from '../maths/rays.ts';
import { dot, norm, sub, type Vec3 } from '../maths/vec.ts';
import type { Tool } from '../net/protocol.ts';
import { kKinds, type ShownKind } from '../state/overlay_kinds.ts';
import {
    type Hands,
    kViews,
    type SectionName,
    type State,
    tipIsInScan,
    type ViewName,
    type Way,
} from '../state/state.ts';
import { lengthText, scaleOf, textWithUnit } from '../state/units.ts';
import { cutCrossings } from '../tools/cuts.ts';
import type { Session } from '../tools/session.ts';
import { hasTwoPlanes, type PlaneOfView, planesOf } from '../views/planes.ts';
import { spotInView } from '../views/projection.ts';
import {
    kSectionAxes,
    pixelOfWorld,
    sectionPlane,
    type SectionPlane,
} from '../views/section_geometry.ts';
import { button, h, svg } from './dom.ts';
import { HandNote, obstacleMark } from './hand_note.ts';
import { overlayValue } from './legend.ts';
import { marksInEndoscope, marksInSection } from './mark_drawings.ts';
import { namesInEndoscope, namesInSection } from './name_marks.ts';
import { catheterMarks, instrumentMarks } from './section_marks.ts';

const kTitles: Record<ViewName, string> = {
    endoscope: 'Endoscope',
    axial: 'Axial',
    coronal: 'Coronal',
    sagittal: 'Sagittal',
};
// Lengths for a patient (scaleOf).
const kPathSight = 60; // length of a path that the endoscope shows [mm]
const kNearSection = 2; // distance of path points that are drawn strong [mm]

export class Overlay {
    readonly views: Record<ViewName, HTMLElement>;
    readonly element: HTMLElement;
    private readonly drawings: Record<ViewName, SVGSVGElement>;
    private readonly captions: Record<ViewName, HTMLElement>;
    private readonly names = Object.fromEntries(
        kViews.map((view) => [view, h('span', { class: 'name' }, kTitles[view])]),
    ) as Record<ViewName, HTMLElement>;
    private readonly maximisers: Record<ViewName, HTMLButtonElement>;
    private readonly force = h(
        'div',
        { class: 'force', role: 'meter', 'aria-label': 'force', hidden: true },
        h('i'),
        h('span'),
    );
    private readonly note = new HandNote();
    private wanted = true;
    private balls: readonly unknown[] = [];

    constructor(
        private readonly session: Session,
        toggleMaximised: (view: ViewName) => void,
    ) {
        this.maximisers = Object.fromEntries(
            kViews.map((view) => [view, button('', () => toggleMaximised(view))]),
        ) as Record<ViewName, HTMLButtonElement>;
        this.drawings = Object.fromEntries(
            kViews.map((view) => [view, svg('svg') as SVGSVGElement]),
        ) as Record<ViewName, SVGSVGElement>;
        this.captions = Object.fromEntries(
            kViews.map((view) => [view, h('span', { class: 'caption' })]),
        ) as Record<ViewName, HTMLElement>;
        this.views = Object.fromEntries(
            kViews.map((view) => [view, this.makeView(view)]),
        ) as Record<ViewName, HTMLElement>;
        this.views.endoscope.append(this.force);
        this.element = h('div', { class: 'grid' }, ...kViews.map((view) => this.views[view]));
        session.store.watch(
            ({ display, pointer }) => [display.maximised, pointer.active],
            (maximised, active) => this.layOut(maximised, active),
        );
        session.store.listen(() => {
            this.wanted = true;
        });
        new ResizeObserver(() => {
            this.wanted = true;
        }).observe(this.element);
    }

    /// Length scale of the scan; 1 for a patient.
    private get scale(): number {
        return scaleOf(this.session.store.state.scan.volume);
    }
    /// Distance from a section of points that are drawn strong [mm].
    private get near(): number {
        return this.scale * kNearSection;
    }

    /// Redraws the marks after changes, once per frame.
    refresh(): void {
        const { balls } = this.session.stage;
        if (!this.wanted && balls === this.balls) return;
        this.wanted = false;
        this.balls = balls;
        const { state } = this.session.store;
        if (!this.session.volume) return;
        const { maximised } = state.display;
        for (const view of kViews) {
            if (maximised && maximised !== view) continue;
            const box = this.views[view].getBoundingClientRect();
            if (view === 'endoscope') this.drawEndoscope(state, box);
            else this.drawSection(view, state, box);
        }
        this.drawForce(state.hands);
        const { active } = state.pointer;
        this.note.show(state, this.views[active], this.toolSpot(state, active));
    }

    /// Position in a view of the tool that has an outcome.
    private toolSpot(state: State, view: ViewName): [number, number] | undefined {
        const place = state.tool.outcome?.place;
        if (!place) return undefined;
        const box = this.views[view].getBoundingClientRect();
        if (view !== 'endoscope') return pixelOfWorld(this.planeOf(view, state, box), place);
        const [{ view: seen, width, height }] = planesOf(state, box) as [PlaneOfView];
        return spotInView(seen, place, { width, height }, this.scale);
    }

    /// Shows newtons, logarithmic from a millinewton on. Tissues without forces have no bar: their
    /// energies have no scale that a hand knows.
    private drawForce({ force_n }: Hands): void {
        this.force.hidden = !(force_n > 0);
        const text = `force ${force_n.toFixed(3)} N`;
        const bar = Math.min(Math.log10(1 + 1000 * force_n) * 20, 100);
        (this.force.firstElementChild as HTMLElement).style.width = `${bar}%`;
        (this.force.lastElementChild as HTMLElement).textContent = `${force_n.toFixed(2)} N`;
        this.force.setAttribute('aria-valuenow', bar.toFixed(0));
        this.force.setAttribute('aria-valuetext', text);
        this.force.title = text;
    }

    private planeOf(view: SectionName, state: State, box: DOMRect): SectionPlane {
        const { frames, cursor } = state.sections;
        const { grid } = this.session.volume!;
        return sectionPlane(grid, view, frames[view], cursor, box.width, box.height);
    }

    private makeView(view: ViewName): HTMLElement {
        const letters = view === 'endoscope' ? '' : kSectionAxes[view].letters;
        this.drawings[view].setAttribute('aria-hidden', 'true');
        return h(
            'section',
            {
                class: `view ${view}`,
                tabindex: '0',
                role: 'application',
                'aria-roledescription': 'view',
                'aria-label': `${kTitles[view]}. ${
                    view === 'endoscope' ? 'W and S fly, arrows look' : 'Up and Down scroll'
                }; question mark lists all keys`,
            },
            this.drawings[view] as unknown as HTMLElement,
            this.maximisers[view],
            this.names[view],
            this.captions[view],
            ...[...letters].map((letter, i) =>
                h('span', { class: `letter ${['left', 'right', 'top', 'bottom'][i]}` }, letter),
            ),
        );
    }

    private layOut(maximised: ViewName | null, active: ViewName): void {
        this.element.classList.toggle('single', maximised !== null);
        for (const view of kViews) {
            this.views[view].hidden = maximised !== null && maximised !== view;
            this.views[view].classList.toggle('active', active === view);
            const alone = `${kTitles[view]} alone (double click)`;
            const hint = maximised ? 'all four views (Esc)' : alone;
            this.maximisers[view].className = 'maximise';
            this.maximisers[view].textContent = maximised ? '⊞' : '⤢';
            this.maximisers[view].title = hint;
            this.maximisers[view].setAttribute('aria-label', hint);
        }
    }

    private drawSection(view: SectionName, state: State, box: DOMRect): void {
        const plane = this.planeOf(view, state, box);
        const { cursor } = state.sections;
        const [x, y] = pixelOfWorld(plane, cursor);
        const gap = 12;
        const parts = [
            line('across', 0, y, x - gap, y),
            line('across', x + gap, y, box.width, y),
            line('along', x, 0, x, y - gap),
            line('along', x, y + gap, x, box.height),
            ...this.pathMarks(state.way, plane),
            ...catheterMarks(this.session, plane),
            ...instrumentMarks(this.session, plane),
            ...this.toolMarks(state.hands.others, plane),
            ...this.endoscopeMarks(state.view.camera, plane),
            ...this.cutMarks(state, plane),
            ...obstacleMark(state, plane),
            ...marksInSection(this.session, plane),
            ...namesInSection(this.session, plane),
        ];
        this.show(view, parts, box);
        const { axis } = plane.axes;
        const at = shown(cursor, state.display.space)['xyz'.indexOf(axis)]!;
        const { slab, projection } = state.sections;
        const { volume } = state.scan;
        const thick = slab > 0 ? `, ${projection} of ${slab} mm` : '';
        const place = `${axis} ${lengthText(volume, at)} mm`;
        this.captions[view].textContent =
            `${place}${sliceText(this.session.volume!.grid, plane)}${thick}`;
    }

    /// Cuts where they cross the section.
    private cutMarks({ tool }: State, plane: SectionPlane): SVGElement[] {
        return tool.cuts
            .flatMap((cut) => cutCrossings(cut, plane.centre, plane.axes.normal))
            .map(([a, b]) => line('cut', ...pixelOfWorld(plane, a), ...pixelOfWorld(plane, b)));
    }

    /// Path through the lumen: its projection faint, parts near the section strong.
    private pathMarks({ path, from }: Way, plane: SectionPlane): SVGElement[] {
        const marks: SVGElement[] = [];
        if (path) {
            const spots = path.points.map((p) => pixelOfWorld(plane, p));
            const near = path.points.map(
                (p) => Math.abs(dot(sub(p, plane.centre), plane.axes.normal)) < this.near,
            );
            marks.push(svg('polyline', { class: 'way', points: spots.join(' ') }));
            for (let i = 0; i < spots.length; ++i) {
                if (!near[i]) continue;
                let end = i;
                while (near[end + 1]) ++end;
                const points = spots.slice(i, end + 1).join(' ');
                marks.push(svg('polyline', { class: 'way near', points }));
                i = end;
            }
        }
        if (from) {
            const [cx, cy] = pixelOfWorld(plane, from);
            marks.push(svg('circle', { class: 'way near', cx, cy, r: 5 }));
        }
        return marks;
    }

    /// Path and its start in the endoscope's view, in front of everything.
    private pathFrom(state: State, spot: (p: Vec3) => [number, number] | undefined): SVGElement[] {
        const marks: SVGElement[] = [];
        const { path, from } = state.way;
        if (path && state.view.outside) {
            const points = path.points.map(spot).filter(Boolean).join(' ');
            marks.push(svg('polyline', { class: 'way near', points }));
        } else if (path)
            for (const run of this.visibleRuns(path.points, state))
                marks.push(
                    svg('polyline', {
                        class: 'way inside',
                        points: run.map(spot).filter(Boolean).join(' '),
                    }),
                );
        const begin = from && spot(from);
        if (begin) {
            const [cx, cy] = begin;
            marks.push(svg('circle', { class: 'way near', cx, cy, r: 5 }));
        }
        return marks;
    }

    /// Parts of a path that the endoscope sees: ahead of it, and not behind a wall.
    private visibleRuns(points: readonly Vec3[], { view, scan }: State): Vec3[][] {
        const { volume, surface } = this.session;
        const { eye, look } = view.camera;
        const scale = scaleOf(scan.volume);
        const runs: Vec3[][] = [[]];
        for (const point of points) {
            const way = sub(point, eye);
            const distance = norm(way);
            const isAhead = dot(way, look) > scale && distance < scale * kPathSight;
            if (isAhead && !firstHit(volume!, eye, way, surface, distance))
                runs[runs.length - 1]!.push(point);
            else if (runs[runs.length - 1]!.length) runs.push([]);
        }
        return runs.filter((run) => run.length > 1);
    }

    /// Line of a cut in progress, and the positions of other clients' tools without a body.
    private toolMarks(others: readonly Tool[], plane: SectionPlane): SVGElement[] {
        const marks: SVGElement[] = [];
        const { stroke } = this.session.hand;
        if (stroke?.radius === 0) {
            const points = stroke.path.map((p) => pixelOfWorld(plane, p).join(',')).join(' ');
            marks.push(svg('polyline', { class: 'blade', points }));
        }
        for (const { position, radius } of others) {
            const off = Math.abs(dot(sub(position, plane.centre), plane.axes.normal));
            if (radius > 0 || off >= this.scale) continue;
            const [cx, cy] = pixelOfWorld(plane, position);
            const r = this.scale / plane.mmPerPixel;
            marks.push(svg('circle', { class: 'rim near', cx, cy, r, 'stroke-width': 5.5 }));
            marks.push(svg('circle', { class: 'tool', cx, cy, r }));
        }
        return marks;
    }

    /// Position of the endoscope and the cone of its view: strong where the eye lies in the slice,
    /// else faint.
    private endoscopeMarks({ eye, look }: Camera, plane: SectionPlane): SVGElement[] {
        const { right, up, normal } = plane.axes;
        const [x, y] = pixelOfWorld(plane, eye);
        const off = Math.abs(dot(sub(eye, plane.centre), normal));
        const kind = off < this.near ? 'sight near' : 'sight';
        const [u, v] = [dot(look, right), -dot(look, up)];
        const length = 26;
        const spread = 0.45;
        const corner = (side: number): string =>
            `${x + length * (u - side * spread * v)},${y + length * (v + side * spread * u)}`;
        const cone = `${x},${y} ${corner(1)} ${corner(-1)}`;
        return [
            ...(Math.hypot(u, v) > 0.2 ? [svg('polygon', { class: kind, points: cone })] : []),
            svg('circle', { class: kind, cx: x, cy: y, r: 3.5 }),
        ];
    }

    private drawEndoscope(state: State, box: DOMRect): void {
        const planes = planesOf(state, box);
        const parts = planes.map((plane) => this.partsOf(state, plane));
        if (planes.length > 1)
            this.show(
                'endoscope',
                planes.map(({ x, y, width, height }, n) => {
                    const part = svg('svg', { x, y, width, height });
                    part.append(...parts[n]!, svg('rect', { class: 'plane', width, height }));
                    return part;
                }),
                box,
            );
        else this.show('endoscope', parts[0]!, box);
        const wall = { stop: 'stops at walls', push: 'pushes walls', pass: 'passes walls' }[
            state.flight.wall
        ];
        const angle = `${Math.round(state.view.fieldOfView)}°`;
        const [name, caption] = outsideTexts(state) ?? [
            kTitles.endoscope,
            state.view.onTip ? `${angle}, rides on the catheter’s tip` : `${angle}, ${wall}`,
        ];
        this.names.endoscope.textContent = name;
        this.captions.endoscope.textContent = caption;
    }

    /// Creates the marks over a picture of the endoscope's view.
    private partsOf(state: State, { view, width, height }: PlaneOfView): SVGElement[] {
        const box = { width, height };
        const spotOf = (p: Vec3): [number, number] | undefined =>
            spotInView(view, p, box, this.scale);
        const parts: SVGElement[] = [];
        if (!view.outside) {
            const spot = spotOf(state.sections.cursor);
            if (spot) {
                const [x, y] = spot;
                parts.push(line('across', x - 8, y, x + 8, y), line('along', x, y - 8, x, y + 8));
            }
            const { stroke } = this.session.hand;
            if (stroke?.radius === 0) {
                const points = stroke.path
                    .map((p) => spotOf(p)?.join(','))
                    .filter(Boolean)
                    .join(' ');
                parts.push(svg('polyline', { class: 'blade', points }));
            }
            for (const cut of state.tool.cuts)
                for (const run of this.visibleRuns(cut.line, state))
                    parts.push(
                        svg('polyline', {
                            class: 'cut',
                            points: run.map(spotOf).filter(Boolean).join(' '),
                        }),
                    );
        }
        return [
            ...parts,
            ...this.pathFrom(state, spotOf),
            ...marksInEndoscope(this.session, view, box),
            ...namesInEndoscope(this.session, view, box),
        ];
    }

    private show(view: ViewName, parts: SVGElement[], box: DOMRect): void {
        this.drawings[view].setAttribute('viewBox', `0 0 ${box.width} ${box.height}`);
        this.drawings[view].replaceChildren(...parts);
    }
}

/// Number of the slice, in grids along the patient's axes: from 1 in the scan's order.
function sliceText(grid: Grid, { axes, centre }: SectionPlane): string {
    const axis = grid.direction.findIndex((d) => Math.abs(dot(d, axes.normal)) > 0.9999);
    if (axis < 0) return '';
    const slice = Math.round(voxelFromWorld(grid, centre)[axis]!) + 1;
    return ` · slice ${slice} of ${grid.size[axis]}`;
}

/// Name and caption of the outside view; undefined in the endoscope.
function outsideTexts(state: State): [string, string] | undefined {
    const { view, rendering } = state;
    if (!view.outside) return undefined;
    if (hasTwoPlanes(state)) return ['Fluoroscopy', 'X-rays through the scan, two planes at 90°'];
    if (view.fluoroscopy) return ['Fluoroscopy', 'X-rays through the scan'];
    const cut = tipIsInScan(state) ? ', cut open at the tip' : '';
    if (!view.blended) return ['Outside', `from outside${cut}`];
    return ['Volume', rendering.cut ? `${rendering.preset}${cut}` : rendering.preset];
}

const line = (kind: string, x1: number, y1: number, x2: number, y2: number): SVGElement =>
    svg('line', { class: kind, x1, y1, x2, y2 });

/// Text of the status bar: value, position and index under the pointer.
export function pointerText(session: Session): string {
    const { pointer, sections, display, overlay, scan } = session.store.state;
    const { volume } = session;
    if (!volume) return '';
    const { space } = display;
    const point = pointer.under?.point ?? sections.cursor;
    const ijk = voxelFromWorld(volume.grid, point);
    const value = volume.valueAt(ijk);
    const mm = shown(point, space).map((x) => lengthText(scan.volume, x));
    const index = ijk.map((i) => Math.round(i));
    const where = pointer.under ? '' : 'crosshair: ';
    const shade = value === undefined ? 'outside' : textWithUnit(scan.volume, value);
    const number = overlay.kind === 'none' ? undefined : overlayValue(session);
    const kind = overlay.kind as ShownKind;
    const more = number === undefined ? '' : ` · ${kKinds[kind].text(number, scan.volume)}`;
    const label = session.labelMap.under;
    const named = label ? ` · ${label}` : '';
    const at = `${space} ${mm.join(', ')} mm · ijk ${index.join(', ')}`;
    return `${where}${shade}${more}${named} · ${at}`;
}
