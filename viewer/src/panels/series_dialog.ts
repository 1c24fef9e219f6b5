// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Dialog to choose one of several DICOM series.

import type { Series } from '../tools/series.ts';
import { button, h } from './dom.ts';

/// Lets the user choose a series. @returns its UID; undefined if cancelled
export function chooseSeries(name: string, list: readonly Series[]): Promise<string | undefined> {
    return new Promise((resolve) => {
        let chosen: string | undefined;
        const dialog = h('dialog', { class: 'series', 'aria-label': 'DICOM series' });
        const choices = list.map(({ uid, description, slices }) =>
            button(`${description || uid} (${slices} slices)`, () => {
                chosen = uid;
                dialog.close();
            }),
        );
        choices.forEach((choice, n) => (choice.title = list[n]!.uid));
        dialog.append(
            h('h2', {}, `${name}: which series?`),
            h('div', { class: 'choices' }, ...choices),
            h(
                'div',
                { class: 'row' },
                button('Cancel', () => dialog.close()),
            ),
        );
        dialog.addEventListener('close', () => {
            dialog.remove();
            resolve(chosen);
        });
        document.body.append(dialog);
        dialog.showModal();
    });
}
