// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Line at the tool about a command that did not go as wished, and a ring around the bone that
// stopped it.

import { dot, sub } from '../maths/vec.ts';
import type { State } from '../state/state.ts';
import { pixelOfWorld, type SectionPlane } from '../views/section_geometry.ts';
import { h, svg } from './dom.ts';

const kAside = 18; // distance of the line from the tool [pixels]
const kWidth = 240; // of the line at most [pixels]
const kNear = 2; // distance of a bone that is drawn strong [mm]

export class HandNote {
    readonly element = h('div', { class: 'hand-note', role: 'status', hidden: true });

    /// Shows or hides the line. @param at  the tool in the view; undefined: it is not in it
    show(state: State, view: HTMLElement, at: readonly [number, number] | undefined): void {
        const { outcome } = state.tool;
        this.element.hidden = !outcome;
        if (!outcome) return;
        if (this.element.parentElement !== view) view.append(this.element);
        if (this.element.textContent !== outcome.text) this.element.textContent = outcome.text;
        this.element.classList.toggle('stopped', outcome.isStopped);
        const { width, height } = view.getBoundingClientRect();
        const [x, y] = at ?? [width / 2, height / 2];
        const isRight = x + kAside + kWidth > width;
        const left = isRight ? x - kAside - this.element.offsetWidth : x + kAside;
        this.element.style.left = `${Math.min(Math.max(left, 4), Math.max(width - 60, 4))}px`;
        this.element.style.top = `${Math.min(Math.max(y + kAside, 26), height - 30)}px`;
    }
}

/// Ring in a section around the bone that stopped the tool.
export function obstacleMark({ tool: { outcome } }: State, plane: SectionPlane): SVGElement[] {
    if (!outcome?.obstacle) return [];
    const [cx, cy] = pixelOfWorld(plane, outcome.obstacle);
    const off = Math.abs(dot(sub(outcome.obstacle, plane.centre), plane.axes.normal));
    return [svg('circle', { class: off < kNear ? 'obstacle near' : 'obstacle', cx, cy, r: 9 })];
}
