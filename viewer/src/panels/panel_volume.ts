// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panels of the volume rendering and of slabs in the sections.

import type { TransferPreset } from '../maths/transfer.ts';
import { kProjections } from '../state/state.ts';
import { isInHu, valueLimits } from '../state/units.ts';
import { showsVolume } from '../tools/aim.ts';
import { presetsOf, usePreset } from '../tools/volume_presets.ts';
import { button, checkbox, choice, h } from './dom.ts';
import { type Parts, section } from './panel_parts.ts';

export function volumePanel(parts: Parts): HTMLElement {
    const { store } = parts.session;
    const opacity = parts.number('rendering', 'opacity', {
        label: 'Density',
        unit: '×',
        hint: 'factor of the opacity per millimetre',
        low: 0,
        high: 8,
        step: 0.05,
        curved: true,
        input: (value) => store.set({ rendering: { opacity: Math.max(value, 0) } }),
    });
    return section(
        'Volume rendering',
        false,
        parts.add(
            checkbox(
                'the scan as a volume (Shift+O)',
                () => showsVolume(parts.state.view),
                () => parts.actions.toggleBlended(),
            ),
        ),
        presets(parts),
        opacity,
        threshold(parts),
        parts.add(
            checkbox(
                'cut open at the tip',
                () => parts.state.rendering.cut,
                (cut) =>
                    parts.session.history.step('cut', () => store.set({ rendering: { cut } })),
            ),
        ),
    );
}

/// Creates the buttons of the presets that suit the scan.
function presets(parts: Parts): HTMLElement {
    const { session } = parts;
    const { store, history } = session;
    const row = h('div', { class: 'row', role: 'group', 'aria-label': 'Presets of the volume' });
    const mark = (): void => {
        for (const made of row.querySelectorAll('button'))
            made.ariaPressed = String(made.textContent === store.state.rendering.preset);
    };
    const pick = (preset: TransferPreset) => (): void =>
        history.step('preset', () => {
            usePreset(session, preset);
            store.set({ view: { outside: true, fluoroscopy: false, blended: true } });
        });
    store.watch(
        ({ scan: { volume, loaded } }) => [loaded === 1 && volume],
        (info) => {
            const made = (info ? presetsOf(info) : []).map((preset) =>
                button(preset.name, pick(preset), preset.hint),
            );
            row.replaceChildren(...made);
            mark();
        },
    );
    store.watch(({ rendering }) => [rendering.preset], mark);
    return row;
}

/// Creates the slider of the value from which on the scan is visible. It moves all values.
function threshold(parts: Parts): HTMLElement {
    const { store, history } = parts.session;
    const ct = { unit: 'HU', low: -1000, high: 1000, step: 1 };
    const element = parts.slider({
        label: 'Visible from',
        ...ct,
        limits: () => {
            const { volume } = store.state.scan;
            const [low, high] = volume?.range_hu ?? [ct.low, ct.high];
            return valueLimits(volume, { ...ct, low, high });
        },
        hint: 'lowest value that is visible; moves all values of the preset',
        value: () => parts.state.rendering.transfer[0]!.value + parts.state.rendering.shift,
        input: (value) => {
            const shift = value - store.state.rendering.transfer[0]!.value;
            store.set({ rendering: { shift } });
        },
        begin: () => history.begin(),
        end: () => history.end('visible from'),
    });
    // The values before the first preset are those of CT.
    store.watch(
        ({ scan, rendering }) => [scan.volume, rendering.preset],
        (volume, preset) => {
            element.hidden = !isInHu(volume) && !preset;
        },
    );
    return element;
}

export function slabPanel(parts: Parts): HTMLElement {
    const { store, history } = parts.session;
    return section(
        'Slab',
        false,
        parts.number('sections', 'slab', {
            label: 'Thickness',
            unit: 'mm',
            low: 0,
            high: 100,
            step: 0.5,
            curved: true,
            hint: '0: a plane',
            input: (value) => store.set({ sections: { slab: Math.max(value, 0) } }),
        }),
        parts.add(
            choice(
                'Projection (U)',
                kProjections.map((value) => ({ value, text: value })),
                () => parts.state.sections.projection,
                (projection) =>
                    history.step('projection', () => store.set({ sections: { projection } })),
            ),
        ),
    );
}
