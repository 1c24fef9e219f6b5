// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Legend of the overlay: the colour map with its range, and a mark at the value under the pointer.

import { cssOf } from '../maths/colour_map.ts';
import { voxelFromWorld } from '../maths/grid.ts';
import { add, mul, norm, normalized, sub, type Vec3 } from '../maths/vec.ts';
import { kKinds, rangeOf } from '../state/overlay_kinds.ts';
import type { State, View } from '../state/state.ts';
import type { Session } from '../tools/session.ts';
import { h } from './dom.ts';

const kBehind = 0.7; // as in shaders/endoscope.frag.glsl [voxels]

/// Value of the overlay under the pointer, else at the crosshair.
export function overlayValue(session: Session): number | undefined {
    const { overlay } = session.stage;
    const { state } = session.store;
    if (!overlay || !session.volume || overlay.kind !== state.overlay.kind) return undefined;
    const { under } = state.pointer;
    const point = under?.point ?? state.sections.cursor;
    const ijk = voxelFromWorld(session.volume.grid, point);
    const onWall = under?.view === 'endoscope';
    return overlay.valueAt(onWall ? add(ijk, behind(session, point, state.view)) : ijk);
}

/// Step from the surface into the tissue [voxels].
function behind(session: Session, point: Vec3, view: View): Vec3 {
    const { grid } = session.volume!;
    const eye = view.outside ? sub(point, view.orbit.direction) : view.camera.eye;
    const way = sub(voxelFromWorld(grid, point), voxelFromWorld(grid, eye));
    return norm(way) > 0 ? mul(kBehind, normalized(way)) : [0, 0, 0];
}

export class Legend {
    private readonly title = h('span', { class: 'title' });
    private readonly bar = h('div', { class: 'bar' }, h('i'));
    private readonly ends = [h('span'), h('span')];
    readonly element = h(
        'div',
        { class: 'legend', role: 'img', hidden: true },
        this.bar,
        h('div', { class: 'ends' }, this.ends[0], this.title, this.ends[1]),
    );

    constructor(private readonly session: Session) {
        session.store.watch(
            ({ overlay, scan }) => [overlay, scan.extreme],
            () => this.show(session.store.state),
        );
    }

    /// Updates the mark, once per frame.
    refresh(): void {
        if (this.element.hidden) return;
        const value = overlayValue(this.session);
        const { low, high } = rangeOf(this.session.store.state);
        const mark = this.bar.firstElementChild as HTMLElement;
        mark.hidden = value === undefined;
        if (value === undefined) return;
        const share = Math.min(Math.max((value - low) / (high - low), 0), 1);
        mark.style.left = `${100 * share}%`;
    }

    private show(state: State): void {
        const { kind } = state.overlay;
        this.element.hidden = kind === 'none';
        if (kind === 'none') return;
        const { title, hint, colours, label } = kKinds[kind];
        const { low, high } = rangeOf(state);
        this.title.textContent = title;
        this.element.title = hint;
        this.bar.style.background = `linear-gradient(to right, ${colours.map(cssOf).join(', ')})`;
        [low, high].forEach((value, i) => {
            this.ends[i]!.textContent = label(value);
        });
        this.element.setAttribute(
            'aria-label',
            `Legend: ${title}, from ${label(low)} to ${label(high)}`,
        );
    }
}
