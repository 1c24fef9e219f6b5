// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The panel of X-rays through the scan: how dark what is in their way becomes.

import { kFieldStops } from '../state/store.ts';
import { button, checkbox, choice, h } from './dom.ts';
import { type Parts, section } from './panel_parts.ts';

const kShadows = [
    { text: 'Soft', contrast: 0.6 },
    { text: 'Usual', contrast: 1 },
    { text: 'Vessels', contrast: 2.5 },
] as const;

export function fluoroscopyPanel(parts: Parts): HTMLElement {
    const { store } = parts.session;
    const contrast = parts.number('fluoroContrast', {
        label: 'Contrast',
        unit: '×',
        low: 0.2,
        high: 5,
        step: 0.1,
        input: (value) => store.set({ fluoroContrast: Math.max(value, 0.01) }),
    });
    const exposure = parts.number('fluoroExposure', {
        label: 'Exposure',
        unit: '×',
        low: 0.1,
        high: 4,
        step: 0.05,
        curved: true,
        hint: 'of what the picture needs by itself',
        input: (value) => store.set({ fluoroExposure: Math.max(value, 0.01) }),
    });
    const noise = parts.number('fluoroNoise', {
        label: 'Noise',
        unit: '×',
        low: 0,
        high: 4,
        step: 0.1,
        hint: '0: none',
        input: (value) => store.set({ fluoroNoise: Math.max(value, 0) }),
    });
    const collimator = choice(
        'Collimator',
        kFieldStops.map((value) => ({ value, text: value })),
        () => parts.state.fluoroField,
        (fluoroField) => store.set({ fluoroField }),
    );
    const presets = h(
        'div',
        { class: 'row' },
        ...kShadows.map((shadow) =>
            button(shadow.text, () =>
                store.set({
                    fluoroContrast: shadow.contrast,
                    fluoroExposure: 1,
                    fluoroscopy: true,
                    outside: true,
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
                () => parts.state.fluoroscopy && parts.state.outside,
                () => parts.actions.toggleFluoroscopy(),
            ),
        ),
        presets,
        contrast,
        exposure,
        noise,
        parts.add(collimator),
    );
}
