// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A folder may hold several DICOM series: the user says which one is meant.

import { button, h } from './dom.ts';

export interface Series {
    readonly uid: string;
    readonly description: string;
    readonly slices: number;
}

/// The server's list. @throws an Error with one line where it is none
export function readSeries(text: string): Series[] {
    const { series } = JSON.parse(text) as { series?: Series[] };
    if (!Array.isArray(series) || !series.length) throw new Error('expected a list of series');
    return series;
}

/// Asks for one of them. @returns nothing where the user wants none
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
            h('div', { class: 'row' }, button('Cancel', () => dialog.close())),
        );
        dialog.addEventListener('close', () => {
            dialog.remove();
            resolve(chosen);
        });
        document.body.append(dialog);
        dialog.showModal();
    });
}
