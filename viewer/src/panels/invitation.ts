// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The own link as text and as a QR code, for others to join. It contains a secret, so it is shown
// on request only.

import { encode } from 'uqr';
import type { Session } from '../tools/session.ts';
import { button, h, svg } from './dom.ts';

const kBorder = 4; // quiet zone of the code [modules]

/// Link of a page without the settings of its own client.
export function invitingLink(address: string): string {
    const url = new URL(address);
    const own = new URLSearchParams(url.hash.slice(1));
    const role = own.get('role') === 'view' ? '&role=view' : '';
    url.hash = `token=${own.get('token') ?? ''}${role}`;
    return url.href;
}

/// QR code, dark on light in both themes.
export function qrCode(text: string): SVGElement {
    const { data, size } = encode(text, { border: kBorder, ecc: 'M' });
    const rows = data.flatMap((row, y) =>
        row.flatMap((dark, x) => (dark ? [`M${x} ${y}h1v1h-1z`] : [])),
    );
    const code = svg('svg', {
        class: 'qr',
        viewBox: `0 0 ${size} ${size}`,
        'shape-rendering': 'crispEdges',
        role: 'img',
        'aria-label': 'QR code of the link',
    });
    code.append(
        svg('rect', { width: size, height: size, fill: '#fff' }),
        svg('path', { d: rows.join(''), fill: '#000' }),
    );
    return code;
}

export function invitation(session: Session): HTMLElement {
    const field = h('input', {
        type: 'text',
        readonly: true,
        'aria-label': 'Link to this scene',
        onfocus: () => field.select(),
    });
    const hint = h('p', { class: 'quiet' });
    const code = h('div');
    const copy = button('Copy', () => void copyLink(), 'copies the link');
    const sheet = h(
        'div',
        { class: 'invitation', hidden: true },
        hint,
        h('div', { class: 'row' }, field, copy),
        code,
    );
    const toggle = button(
        'Invite…',
        () => show(sheet.hidden === true),
        'the link, and its QR code',
    );
    toggle.setAttribute('aria-expanded', 'false');

    async function copyLink(): Promise<void> {
        try {
            await navigator.clipboard.writeText(field.value);
            session.say('the link is copied');
        } catch {
            field.select();
            session.warn('the browser does not let the page copy: press Ctrl+C');
        }
    }
    function show(is: boolean): void {
        sheet.hidden = !is;
        toggle.setAttribute('aria-expanded', String(is));
        if (!is) return;
        const link = invitingLink(location.href);
        field.value = link;
        hint.textContent = hintOf(session, new URL(link).hostname);
        code.replaceChildren(qrCode(link));
    }
    return h('div', { class: 'column wide' }, toggle, sheet);
}

function hintOf({ connection }: Session, host: string): string {
    const local = /^(localhost|127\.|\[::1\])/.test(host)
        ? ' It works on this computer only; pliant serve --host lets others in.'
        : '';
    return connection.role === 'control'
        ? 'Who has this link can change the scene. The second link that pliant serve printed is ' +
              `for viewing only.${local}`
        : `Who has this link can view the scene.${local}`;
}
