// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Question before a scan is opened or a state of the tissue loaded: it replaces the present one for
// everyone.

import type { Replacement } from '../tools/files.ts';
import { button, h } from './dom.ts';

/// Asks whether to open a scan, or to load a state.
export function askToReplace(by: Replacement): Promise<boolean> {
    const { what, name, present, others, labels } = by;
    const verb = what === 'state' ? 'Load' : 'Open';
    return new Promise((resolve) => {
        let agreed = false;
        const dialog = h('dialog', { class: 'replace', 'aria-label': `${verb} a ${what}` });
        const agree = button(labels ? 'Open it as a scan' : verb, () => {
            agreed = true;
            dialog.close();
        });
        const cancel = button('Cancel', () => dialog.close());
        (labels ? cancel : agree).autofocus = true;
        const people = `${others} other${others > 1 ? 's' : ''}`;
        const company = others > 0 ? ` for you and ${people} in this session` : '';
        dialog.append(
            h('h2', {}, `${verb} ${name}?`),
            labels
                ? h(
                      'p',
                      { class: 'warning' },
                      `${name} looks like a label map (${labels}), not like a scan: `,
                      'its labels would be shown as grey values.',
                  )
                : '',
            h(
                'p',
                {},
                what === 'state'
                    ? `It replaces the present state of the tissue of ${present}${company}. `
                    : `It replaces ${present}${company}. `,
                'What was done to the tissue is lost, and this can’t be undone: save first what ' +
                    'you need.',
            ),
            h('div', { class: 'row' }, agree, cancel),
        );
        dialog.addEventListener('close', () => {
            dialog.remove();
            resolve(agreed);
        });
        document.body.append(dialog);
        dialog.showModal();
    });
}
