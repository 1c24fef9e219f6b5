// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panel of fluoroscopy: contrast, exposure, noise and collimator.

import { kFieldStops } from '../state/state.ts';
import { hasTwoPlanes } from '../views/planes.ts';
import { button, checkbox, choice, h } from './dom.ts';
import { type Parts, section } from './panel_parts.ts';

const kShadows = [
    { text: 'Soft', contrast: 0.6 },
    { text: 'Usual', contrast: 1 },
    { text: 'Vessels', contrast: 2.5 },
] as const;

export function fluoroscopyPanel(parts: Parts): HTMLElement {
    const { store } = parts.session;
    const contrast = parts.number('fluoro', 'contrast', {
        label: 'Contrast',
        unit: '×',
        low: 0.2,
        high: 5,
        step: 0.1,
        input: (value) => store.set({ fluoro: { contrast: Math.max(value, 0.01) } }),
    });
    const exposure = parts.number('fluoro', 'exposure', {
        label: 'Exposure',
        unit: '×',
        low: 0.1,
        high: 4,
        step: 0.05,
        curved: true,
        hint: 'factor of the automatic exposure',
        input: (value) => store.set({ fluoro: { exposure: Math.max(value, 0.01) } }),
    });
    const noise = parts.number('fluoro', 'noise', {
        label: 'Noise',
        unit: '×',
        low: 0,
        high: 4,
        step: 0.1,
        hint: '0: none',
        input: (value) => store.set({ fluoro: { noise: Math.max(value, 0) } }),
    });
    const collimator = choice(
        'Collimator',
        kFieldStops.map((value) => ({ value, text: value })),
        () => parts.state.fluoro.field,
        (field) => store.set({ fluoro: { field } }),
    );
    const presets = h(
        'div',
        { class: 'row' },
        ...kShadows.map((shadow) =>
            button(shadow.text, () =>
                store.set({
                    fluoro: { contrast: shadow.contrast, exposure: 1 },
                    view: { fluoroscopy: true, outside: true },
                }),
            ),
        ),
    );
    return section(
        'Fluoroscopy',
        false,
        parts.add(
            checkbox(
                'X-rays through the scan (B)',
                () => parts.state.view.fluoroscopy && parts.state.view.outside,
                () => parts.actions.toggleFluoroscopy(),
            ),
        ),
        parts.add(
            checkbox(
                'second plane, at 90° (Shift+B)',
                () => hasTwoPlanes(parts.state),
                () => parts.actions.toggleBiplane(),
            ),
        ),
        presets,
        contrast,
        exposure,
        noise,
        parts.add(collimator),
    );
}
