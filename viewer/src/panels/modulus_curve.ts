// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Editor of Young's modulus by value, over the scan's histogram. Moduli are on a logarithmic axis,
// voids below it.
//
// Points are dragged; a double click adds one, or removes the one under the pointer. With the
// keyboard: arrows move the focused point, Delete removes it, + adds one after it.

import {
    heightOf,
    kDecades,
    kpaAt,
    type Moduli,
    modulusAt,
    withAdded,
    withMoved,
    withoutPoint,
} from '../maths/moduli.ts';
import type { Limits } from '../state/units.ts';
import { h, svg } from './dom.ts';

const kWidth = 240; // of the drawing [px]
const kHeight = 110;
const kEdge = 7; // around it
const kSteps = 120; // of the curve's line
const kKeyHeights = 0.02; // of the axis, for a key

export class ModulusCurve {
    readonly element: HTMLElement;
    private readonly drawing = svg('svg', {
        viewBox: `${-kEdge} ${-kEdge} ${kWidth + 2 * kEdge} ${kHeight + 2 * kEdge}`,
        class: 'moduli',
        role: 'group',
        'aria-label': "Young's modulus by value",
    });
    private readonly bars = svg('path', { class: 'histogram' });
    private readonly bone = svg('rect', { class: 'bone', y: 0, height: kHeight });
    private readonly line = svg('path', { class: 'line' });
    private readonly points = svg('g');
    private readonly text = h('small', { class: 'quiet' });
    private moduli: Moduli = [];
    private held = Infinity; ///< values above it don't move
    private dragged: number | undefined;
    private moved = false; ///< since the point was taken

    /// @param limits  of the values
    /// @param change  called after each change of the table
    constructor(
        private readonly limits: () => Limits,
        private readonly change: (moduli: Moduli) => void,
    ) {
        this.drawing.append(this.bars, this.bone, ...this.gridLines(), this.line, this.points);
        this.element = h('div', {}, this.drawing, this.text);
        this.drawing.addEventListener('dblclick', (event) => this.toggleAt(event as MouseEvent));
        this.drawing.addEventListener('pointermove', (event) => this.drag(event as PointerEvent));
        for (const end of ['pointerup', 'pointercancel'])
            this.drawing.addEventListener(end, () => this.drop());
    }

    /// Shows the table in use, unless a point is being dragged.
    show(moduli: Moduli, heldAbove = Infinity): void {
        this.held = heldAbove;
        if (this.dragged === undefined) this.draw(moduli);
    }

    /// Logarithmic bars, so that rare values are seen too.
    setHistogram(counts: Float64Array): void {
        const most = Math.log1p(counts.reduce((a, b) => Math.max(a, b), 0)) || 1;
        const width = kWidth / counts.length;
        let path = '';
        counts.forEach((count, i) => {
            const height = (kHeight * Math.log1p(count)) / most;
            path += `M${i * width},${kHeight}v${-height}h${width}v${height}z`;
        });
        this.bars.setAttribute('d', path);
    }

    private gridLines(): SVGElement[] {
        const lines = [];
        for (let kpa = kDecades.low; kpa <= kDecades.high; kpa *= 10) {
            const y = kHeight * (1 - heightOf(kpa));
            const label = svg('text', { x: 1, y: y - 1 });
            label.textContent = `${Number(kpa.toPrecision(1))} kPa`;
            lines.push(svg('path', { class: 'decade', d: `M0,${y}h${kWidth}` }), label);
        }
        return lines;
    }

    private xOf(value: number): number {
        const { low, high } = this.limits();
        return Math.min(Math.max((kWidth * (value - low)) / (high - low), 0), kWidth);
    }

    private valueAt(x: number): number {
        const { low, high, step } = this.limits();
        const value = low + (x / kWidth) * (high - low);
        return Math.min(Math.max(Math.round(value / step) * step, low), high);
    }

    private draw(moduli: Moduli): void {
        this.moduli = moduli;
        const x = this.xOf(this.held);
        this.bone.setAttribute('x', String(x));
        this.bone.setAttribute('width', String(kWidth - x));
        if (moduli.length === 0) return;
        const { low, high } = this.limits();
        const at = (value: number): string =>
            `${this.xOf(value)},${kHeight * (1 - heightOf(modulusAt(moduli, value)))}`;
        const values = Array.from(
            { length: kSteps + 1 },
            (_, i) => low + (i / kSteps) * (high - low),
        );
        this.line.setAttribute('d', `M${values.map(at).join('L')}`);
        while (this.points.childElementCount > moduli.length) this.points.lastChild!.remove();
        while (this.points.childElementCount < moduli.length)
            this.points.append(this.newPoint(this.points.childElementCount));
        moduli.forEach(([value, kpa], i) => {
            const point = this.points.children[i]!;
            const [cx, cy] = at(value).split(',');
            point.setAttribute('cx', cx!);
            point.setAttribute('cy', cy!);
            point.setAttribute('aria-valuenow', String(kpa));
            point.setAttribute('aria-valuetext', this.textOf(i));
        });
    }

    private textOf(i: number): string {
        const [value, kpa] = this.moduli[i]!;
        const unit = this.limits().unit;
        const modulus = kpa > 0 ? `${kpa} kPa` : 'void';
        return `${value}${unit && ` ${unit}`}: ${modulus}`;
    }

    private newPoint(i: number): SVGElement {
        const point = svg('circle', {
            r: 5,
            tabindex: 0,
            role: 'slider',
            'aria-label': `Point ${i + 1}`,
            'aria-valuemin': 0,
            'aria-valuemax': kDecades.high,
        });
        const tell = (): void => {
            if (this.moduli[i]) this.text.textContent = this.textOf(i);
        };
        point.addEventListener('pointerdown', (event) => {
            const { pointerId } = event as PointerEvent;
            if (this.isLocked()) return;
            this.dragged = i;
            this.drawing.setPointerCapture(pointerId);
            point.focus();
        });
        point.addEventListener('pointerenter', tell);
        point.addEventListener('focus', tell);
        point.addEventListener('keydown', (event) => this.press(i, event as KeyboardEvent));
        return point;
    }

    /// Position in the drawing: value, and height 0…1.
    private placeOf(event: MouseEvent): { value: number; height: number } {
        const box = this.drawing.getBoundingClientRect();
        const scale = (kWidth + 2 * kEdge) / Math.max(box.width, 1);
        const x = (event.clientX - box.left) * scale - kEdge;
        const y = (event.clientY - box.top) * scale - kEdge;
        return { value: this.valueAt(x), height: 1 - y / kHeight };
    }

    private drag(event: PointerEvent): void {
        if (this.dragged === undefined) return;
        const { value, height } = this.placeOf(event);
        const { step } = this.limits();
        this.draw(withMoved(this.moduli, this.dragged, [value, kpaAt(height)], step));
        this.text.textContent = this.textOf(this.dragged);
        this.moved = true;
    }

    private drop(): void {
        if (this.dragged === undefined) return;
        this.dragged = undefined;
        if (this.moved) this.change(this.moduli);
        this.moved = false;
    }

    /// Whether this client only views.
    private isLocked(): boolean {
        return this.element.closest('fieldset')?.disabled ?? false;
    }

    /// Adds a point, or removes the one there.
    private toggleAt(event: MouseEvent): void {
        const at = [...this.points.children].indexOf(event.target as Element);
        const { value, height } = this.placeOf(event);
        this.take(
            at < 0
                ? withAdded(this.moduli, [value, kpaAt(height)], this.limits().step)
                : withoutPoint(this.moduli, at),
        );
    }

    private take(moduli: Moduli): void {
        if (moduli === this.moduli || this.isLocked()) return;
        this.draw(moduli);
        this.change(moduli);
    }

    private press(i: number, event: KeyboardEvent): void {
        const [value, kpa] = this.moduli[i]!;
        const { step } = this.limits();
        const next = this.moduli[i + 1];
        const to = (dv: number, dh: number): Moduli =>
            withMoved(
                this.moduli,
                i,
                [value + dv * step, dh ? kpaAt(heightOf(kpa) + dh * kKeyHeights) : kpa],
                step,
            );
        const keys: Record<string, () => Moduli> = {
            ArrowLeft: () => to(-1, 0),
            ArrowRight: () => to(1, 0),
            ArrowUp: () => to(0, kpa > 0 ? 1 : 4),
            ArrowDown: () => to(0, kpa > kDecades.low ? -1 : -4),
            Delete: () => withoutPoint(this.moduli, i),
            '+': () => {
                const middle = next ? 0.5 * (value + next[0]) : value + 10 * step;
                return withAdded(this.moduli, [middle, modulusAt(this.moduli, middle)], step);
            },
        };
        const act = keys[event.key];
        if (!act) return;
        event.preventDefault();
        event.stopPropagation();
        this.take(act());
        if (this.moduli[i]) this.text.textContent = this.textOf(i);
    }
}
