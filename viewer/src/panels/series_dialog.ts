// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Dialog to choose one of several DICOM series, or one of the images of a file.

import {
    type Choice,
    type Choices,
    kSeriesColumns,
    type Series,
    seriesRow,
} from '../tools/series.ts';
import { button, h } from './dom.ts';

/// Creates a table whose rows are chosen by a click, or by the button at their description.
function seriesTable(series: readonly Series[], choose: (uid: string) => void): HTMLElement {
    const name = kSeriesColumns.indexOf('description');
    const rows = series.map((one) => {
        const { uid, fault } = one;
        const cells = seriesRow(one).map((text, column) => {
            if (column !== name) return h('td', {}, text);
            return h('td', {}, h('button', { type: 'button', title: uid }, text || uid));
        });
        return h('tr', { onclick: () => choose(uid), title: fault ?? '' }, ...cells);
    });
    const heads = kSeriesColumns.map((text) => h('th', { scope: 'col' }, text));
    return h(
        'table',
        { class: 'choices' },
        h('thead', {}, h('tr', {}, ...heads)),
        h('tbody', {}, ...rows),
    );
}

/// Lets the user choose. @returns undefined if cancelled
export function chooseScan(name: string, { series, frames }: Choices): Promise<Choice | undefined> {
    return new Promise((resolve) => {
        let chosen: Choice | undefined;
        const choose = (choice: Choice): void => {
            chosen = choice;
            dialog.close();
        };
        const what = series ? 'DICOM series' : 'image of the file';
        const dialog = h('dialog', { class: 'series', 'aria-label': what });
        const last = String((frames ?? 1) - 1);
        const frame = h('input', { type: 'number', min: '0', max: last, step: '1', value: '0' });
        const open = (event: Event): void => {
            event.preventDefault();
            choose({ frame: frame.value });
        };
        const field = h(
            'form',
            { class: 'choices', onsubmit: open },
            h('label', { class: 'field' }, `image 0…${last}`, frame),
            h('button', {}, 'Open'),
        );
        dialog.append(
            h('h2', {}, series ? `${name}: which series?` : `${name}: which of ${frames} images?`),
            series ? seriesTable(series, (uid) => choose({ series: uid })) : field,
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
