// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Line in the endoscope's view about the client whose camera is followed.

import { nameOfClient } from '../state/company.ts';
import type { Session } from '../tools/session.ts';
import { h } from './dom.ts';

export function followLine({ store }: Session): HTMLElement {
    const line = h('div', { class: 'following', role: 'status', hidden: true });
    store.watch(
        ({ company, shared }) => [company.leader, shared?.clients],
        (leader, clients) => {
            line.hidden = !leader;
            if (!clients?.some((c) => c.client === leader)) return; // the name stays meanwhile
            const name = nameOfClient(store.state.shared, leader);
            const text = `following ${name}; any own flight or look ends it`;
            if (line.textContent !== text) line.textContent = text;
        },
    );
    return line;
}
