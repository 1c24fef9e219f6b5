// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Dialog with the table of keys and gestures, from the keymap's list.

import { kHelp } from '../tools/keymap.ts';
import { button, h } from './dom.ts';

export function helpDialog(startTour: () => void): HTMLDialogElement {
    const dialog = h('dialog', { class: 'help', 'aria-label': 'Keys and gestures' });
    dialog.append(
        h('h2', {}, 'Keys and gestures'),
        h(
            'div',
            { class: 'columns' },
            ...kHelp.map(({ title, lines }) =>
                h(
                    'section',
                    {},
                    h('h3', {}, title),
                    h(
                        'dl',
                        {},
                        ...lines.flatMap(({ keys, text }) => [
                            h('dt', {}, keys),
                            h('dd', {}, text),
                        ]),
                    ),
                ),
            ),
        ),
        h(
            'div',
            { class: 'row' },
            button('Tour', () => {
                dialog.close();
                startTour();
            }),
            button('Close', () => dialog.close()),
        ),
        h('small', {}, 'Pliant is a research tool. It is not for clinical use.'),
    );
    return dialog;
}
