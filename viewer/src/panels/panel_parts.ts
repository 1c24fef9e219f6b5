// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What all panels are made of: controls that follow the store, numbers that can be undone, sections
// that fold.

import type { State } from '../state/store.ts';
import type { Actions } from '../tools/actions.ts';
import type { Session } from '../tools/session.ts';
import { type Control, h, slider, type SliderSettings } from './dom.ts';

export class Parts {
    private readonly controls: Control[] = [];

    constructor(
        readonly session: Session,
        readonly actions: Actions,
    ) {}

    get state(): Readonly<State> {
        return this.session.store.state;
    }

    refresh(): void {
        for (const control of this.controls) control.refresh();
    }

    add(control: Control): HTMLElement {
        this.controls.push(control);
        return control.element;
    }

    number(
        key:
            | 'window'
            | 'level'
            | 'fieldOfView'
            | 'barrel'
            | 'fog'
            | 'speed'
            | 'tip'
            | 'radius'
            | 'strength'
            | 'depth'
            | 'overlayOpacity'
            | 'overlayMm'
            | 'overlayGrowth'
            | 'fluoroContrast'
            | 'fluoroExposure'
            | 'fluoroNoise',
        settings: Pick<SliderSettings, 'label' | 'unit' | 'low' | 'high' | 'step'> &
            Partial<SliderSettings>,
    ): HTMLElement {
        return this.add(
            slider({
                value: () => this.state[key],
                input: (value) => this.session.store.set({ [key]: value }),
                begin: () => this.session.history.begin(),
                end: () => this.session.history.end(settings.label.toLowerCase()),
                ...settings,
            }),
        );
    }
}

export function section(title: string, open: boolean, ...children: (Node | false)[]): HTMLElement {
    const body = h('div', { class: 'body' }, ...children);
    return h('details', open ? { open: true } : {}, h('summary', {}, title), body);
}

/// Settings that change the tissue, or what all see: only for those who control.
export const tissue = (...children: Node[]): HTMLElement =>
    h('fieldset', { class: 'tissue' }, ...children);
