// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panel of the session: its clients, the own name, the link with its QR code, and a comparison of
// the page's voxels with the server's.

import { nameOfClient } from '../state/company.ts';
import { button, checkbox, h } from './dom.ts';
import { invitation } from './invitation.ts';
import { type Parts, section } from './panel_parts.ts';

const kLongestName = 40; // of the protocol
const kNameKey = 'pliant.name';

/// Name that this browser's user has chosen; empty: none.
export const keptName = (): string => localStorage.getItem(kNameKey) ?? '';

export function sessionPanel(parts: Parts): HTMLElement {
    const { store } = parts.session;
    const result = h('output', { class: 'checksum' });
    return section(
        'Session',
        false,
        people(parts),
        ownName(parts),
        parts.add(
            checkbox(
                'names at the tools of others',
                () => parts.state.company.names,
                (names) => store.set({ company: { names } }),
            ),
        ),
        invitation(parts.session),
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

/// Row of a client, which stays the same element while the client is here.
interface Row {
    readonly element: HTMLElement;
    readonly name: HTMLElement;
    readonly role: HTMLElement;
    readonly follow: HTMLButtonElement;
}

function people({ session }: Parts): HTMLElement {
    const { store, follow } = session;
    const rows = new Map<number, Row>();
    const list = h('ul', { class: 'people' });
    const rowOf = (client: number): Row => {
        const known = rows.get(client);
        if (known) return known;
        const name = h('span', { class: 'person' });
        const role = h('small');
        const toggle = button('Follow', () => {
            if (store.state.company.leader === client) follow.end();
            else follow.begin(client);
        });
        const row = { element: h('li', {}, name, role, toggle), name, role, follow: toggle };
        rows.set(client, row);
        return row;
    };
    store.watch(
        ({ shared, link, company }) => [shared?.clients, link, company.leader],
        (clients = [], link, leader) => {
            for (const c of clients) {
                const { element, name, role, follow: toggle } = rowOf(c.client);
                name.textContent = nameOfClient(store.state.shared, c.client);
                const own = c.client === link.client;
                const may = c.role === 'view' ? 'views' : 'controls';
                role.textContent = own ? `${may} (you)` : may;
                toggle.hidden = own || !link.features.includes('follow');
                toggle.setAttribute('aria-pressed', String(c.client === leader));
                toggle.setAttribute('aria-label', `Follow ${name.textContent}`);
                toggle.title = `your endoscope goes with that of ${name.textContent}`;
                if (element.parentElement !== list) list.append(element);
            }
            for (const [client, { element }] of rows)
                if (!clients.some((c) => c.client === client)) {
                    element.remove();
                    rows.delete(client);
                }
        },
    );
    return list;
}

/// Field of the own name. It is kept in this browser.
function ownName({ session }: Parts): HTMLElement {
    const { store, connection } = session;
    const own = () => store.state.shared?.clients.find((c) => c.client === store.state.link.client);
    const field = h('input', {
        type: 'text',
        maxlength: String(kLongestName),
        autocomplete: 'off',
        placeholder: 'shown to the others',
        onchange: () => {
            const name = field.value.trim();
            const before = own()?.name ?? '';
            if (!name) field.value = before; // a client keeps a name
            else if (name !== before) {
                localStorage.setItem(kNameKey, name);
                connection.rename(name);
            }
        },
        onkeydown: (event) => {
            if ((event as KeyboardEvent).key === 'Enter') field.blur();
        },
    });
    store.watch(
        ({ shared, link }) => [shared?.clients, link.client],
        () => {
            const name = own()?.name;
            if (name !== undefined && document.activeElement !== field) field.value = name;
        },
    );
    return h('label', { class: 'field own-name' }, 'Your name', field);
}
