// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panel of the session: its clients, and a comparison of the page's voxels with the server's.

import { button, h } from './dom.ts';
import { type Parts, section } from './panel_parts.ts';

export function sessionPanel(parts: Parts): HTMLElement {
    const people = h('ul', { class: 'people' });
    parts.session.store.watch(
        ({ shared, link }) => [shared, link],
        (shared, link) => {
            people.replaceChildren(
                ...(shared?.clients ?? []).map((c) =>
                    h(
                        'li',
                        {},
                        `${c.name || `visitor ${c.client}`}`,
                        h('small', {}, c.role === 'view' ? ' views' : ' controls'),
                        c.client === link.client && h('small', {}, ' (you)'),
                    ),
                ),
            );
        },
    );
    const result = h('output', { class: 'checksum' });
    return section(
        'Session',
        false,
        people,
        button(
            'Check this copy',
            () =>
                void parts.session.compare().then((sum) => {
                    result.textContent = sum
                        ? `${sum.same ? 'equal' : 'DIFFERENT'}: ${sum.own}, ${sum.tissue}`
                        : 'no answer';
                }),
            'compares all voxels of this page with those of the server, by checksums',
        ),
        result,
    );
}
