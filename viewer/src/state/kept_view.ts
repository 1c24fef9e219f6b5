// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Keeps the view over a reload of the page: camera, window, settings, keyframes, marks. They lie in
// the tab's own storage and are taken up for the same scan only.

import type { Memory } from '../net/connection.ts';
import type { State } from './state.ts';
import type { Patch, Store } from './store.ts';

const kKey = 'pliant.view.2'; // a new number where the form changes

function keptOf(state: State): Patch {
    const { view, sections, look, fluoro, rendering, flight, overlay } = state;
    const { looks, names, opacity, outline, contact } = state.labels;
    const { maximised, contour, space, timings } = state.display;
    return {
        view,
        sections,
        look,
        fluoro,
        rendering,
        flight,
        overlay,
        tool: { ...state.tool, cuts: [], outcome: null },
        display: { maximised, contour, space, timings },
        movie: { keyframes: state.movie.keyframes },
        marks: { list: state.marks.list, kind: state.marks.kind },
        labels: { looks, names, opacity, outline, contact },
    };
}

/// Identifies a scan by its name and grid.
const scanOf = ({ scan: { volume } }: State): string =>
    volume ? [volume.name, ...volume.size, ...volume.origin_mm].join(' ') : '';

export function keepView({ state }: Store, memory: Memory): void {
    if (state.scan.volume)
        memory.setItem(kKey, JSON.stringify({ scan: scanOf(state), kept: keptOf(state) }));
}

/// Restores the view. @returns whether there was a view of this scan
export function takeUpView(store: Store, memory: Memory): boolean {
    const text = memory.getItem(kKey);
    if (!text) return false;
    const { scan, kept } = JSON.parse(text) as { scan: string; kept: Patch };
    if (scan !== scanOf(store.state)) return false;
    store.set(kept);
    return true;
}
