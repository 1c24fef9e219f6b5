// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parts of panels: controls that follow the store, numbers with undo, folding sections.

import type { VolumeInfo } from '../net/protocol.ts';
import type { State } from '../state/state.ts';
import { lengthLimits, type Limits, valueLimits } from '../state/units.ts';
import type { Actions } from '../tools/actions.ts';
import type { Session } from '../tools/session.ts';
import { type Control, h, slider, type SliderSettings } from './dom.ts';

/// Groups of the state with numbers for sliders.
type Settings =
    | 'view'
    | 'sections'
    | 'flight'
    | 'tool'
    | 'overlay'
    | 'fluoro'
    | 'labels'
    | 'rendering';
type NumberOf<G extends Settings> = keyof {
    [K in keyof State[G] as State[G][K] extends number ? K : never]: 0;
};

export class Parts {
    private readonly controls: Control[] = [];

    constructor(
        readonly session: Session,
        readonly actions: Actions,
    ) {}

    get state(): State {
        return this.session.store.state;
    }

    refresh(): void {
        for (const control of this.controls) control.refresh();
    }

    add(control: Control): HTMLElement {
        this.controls.push(control);
        return control.element;
    }

    /// Creates a slider. Limits in mm and HU are those for CT of a body; they follow the scan.
    slider(settings: SliderSettings): HTMLElement {
        const scan = (): State['scan']['volume'] => this.state.scan.volume;
        const limits: Record<string, () => Limits> = {
            mm: () => lengthLimits(scan(), settings),
            HU: () => valueLimits(scan(), settings),
        };
        return this.add(slider({ limits: limits[settings.unit], ...settings }));
    }

    /// Creates a slider for a number of the state, with undo.
    number<G extends Settings>(
        group: G,
        key: NumberOf<G>,
        settings: Pick<SliderSettings, 'label' | 'unit' | 'low' | 'high' | 'step'> &
            Partial<SliderSettings>,
    ): HTMLElement {
        const { store, history } = this.session;
        return this.slider({
            value: () => store.state[group][key] as number,
            input: (value) => store.set({ [group]: { [key]: value } }),
            begin: () => history.begin(),
            end: () => history.end(settings.label.toLowerCase()),
            ...settings,
        });
    }
}

/// Memoises a list for the present scan: as long as it stays, the list is the same object.
export function perScan<T>(parts: Parts, listOf: (scan: VolumeInfo | null) => T): () => T {
    let scan = parts.state.scan.volume;
    let list = listOf(scan);
    return () => {
        const { volume } = parts.state.scan;
        if (volume !== scan) [scan, list] = [volume, listOf(volume)];
        return list;
    };
}

export function section(title: string, open: boolean, ...children: (Node | false)[]): HTMLElement {
    const body = h('div', { class: 'body' }, ...children);
    return h('details', open ? { open: true } : {}, h('summary', {}, title), body);
}

/// Groups controls that change the tissue or shared settings: disabled for clients that only view.
export const tissue = (...children: Node[]): HTMLElement =>
    h('fieldset', { class: 'tissue' }, ...children);
