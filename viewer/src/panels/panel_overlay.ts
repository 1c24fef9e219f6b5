// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panel of the coloured overlay.

import type { OverlayKind } from '../net/protocol.ts';
import { kKinds } from '../state/overlay_kinds.ts';
import { roundLength } from '../state/units.ts';
import { checkbox, choice, h } from './dom.ts';
import { type Parts, section } from './panel_parts.ts';

export function overlayPanel(parts: Parts): HTMLElement {
    const { store } = parts.session;
    const opacity = parts.number('overlay', 'opacity', {
        label: 'Opacity',
        unit: '',
        low: 0,
        high: 1,
        step: 0.05,
    });
    const auto = parts.add(
        checkbox(
            'range follows the values',
            () => parts.state.overlay.auto,
            (auto) => parts.actions.fixOverlayRange(!auto),
        ),
    );
    const most = parts.number('overlay', 'mm', {
        label: 'Colours up to',
        unit: 'mm',
        low: 0.1,
        high: 50,
        step: 0.1,
        curved: true,
        input: (value) => {
            const least = roundLength(store.state.scan.volume, 0.01);
            store.set({ overlay: { mm: Math.max(value, least) } });
        },
    });
    const growth = parts.number('overlay', 'growth', {
        label: 'Colours up to 1 ±',
        unit: '',
        low: 0.05,
        high: 2,
        step: 0.05,
        input: (value) => store.set({ overlay: { growth: Math.max(value, 0.01) } }),
    });
    const element = section(
        'Overlay',
        false,
        parts.add(
            choice<OverlayKind>(
                'Colours',
                [
                    { value: 'none', text: 'none' },
                    { value: 'displacement', text: 'displacement', hint: kKinds.displacement.hint },
                    { value: 'jacobian', text: 'volume change', hint: kKinds.jacobian.hint },
                ],
                () => parts.state.overlay.kind,
                (kind) => store.set({ overlay: { kind } }),
            ),
        ),
        opacity,
        auto,
        most,
        growth,
        h(
            'small',
            { class: 'quiet' },
            'Key M switches between them. Undeformed tissue is not coloured.',
        ),
    );
    store.watch(
        ({ overlay, link }) => [overlay, link],
        (overlay, link) => {
            element.hidden = link.status === 'open' && !link.features.includes('overlay');
            opacity.hidden = auto.hidden = overlay.kind === 'none';
            most.hidden = overlay.kind !== 'displacement' || overlay.auto;
            growth.hidden = overlay.kind !== 'jacobian' || overlay.auto;
        },
    );
    return element;
}
