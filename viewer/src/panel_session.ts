// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Who is here, what can be saved, and whether page and server hold the same.

import { button, h } from './dom.ts';
import { type Parts, section } from './panel_parts.ts';

export function sessionPanel(parts: Parts): HTMLElement {
    const people = h('ul', { class: 'people' });
    const save = h('div', { class: 'column' });
    parts.session.store.watch(['shared', 'client', 'features', 'link'], (state) => {
        people.replaceChildren(
            ...(state.shared?.clients ?? []).map((c) =>
                h(
                    'li',
                    {},
                    `${c.name || `visitor ${c.client}`}`,
                    h('small', {}, c.role === 'view' ? ' views' : ' controls'),
                    c.client === state.client && h('small', {}, ' (you)'),
                ),
            ),
        );
    });
    parts.session.store.watch(['features'], ({ features }) => {
        const files = ['volume.nrrd', 'displacement.nrrd', 'transform.nrrd', 'session.pls'];
        save.replaceChildren(
            ...(features.includes('save')
                ? files.map((name) =>
                      h(
                          'a',
                          { href: `save/${name}${parts.query}`, download: name },
                          `Save ${name}`,
                      ),
                  )
                : []),
        );
    });
    const result = h('output', { class: 'checksum' });
    return section(
        'Session',
        false,
        people,
        save,
        button(
            'Compare with the server',
            () =>
                void parts.session.compare().then((sum) => {
                    result.textContent = sum
                        ? `${sum.same ? 'equal' : 'DIFFERENT'}: ${sum.own}, ${sum.tissue}`
                        : 'no answer';
                }),
            'checksum of all voxels, here and there',
        ),
        result,
    );
}
