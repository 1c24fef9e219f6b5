// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panel of the label map: opacity, and the list of labels with colour, name, and ticks for shown,
// at risk, and target.

import { cssOf } from '../maths/colour_map.ts';
import { type Label, type LabelLook, lookOf, nameOf } from '../state/labels.ts';
import { button, checkbox, h } from './dom.ts';
import { type Parts, section } from './panel_parts.ts';

const kColumns: readonly { key: keyof LabelLook; head: string; hint: string }[] = [
    { key: 'shown', head: 'show', hint: 'drawn in colour' },
    { key: 'risk', head: 'risk', hint: 'a tool that touches it warns' },
    { key: 'target', head: 'target', hint: 'shimmers through walls' },
];

export function labelsPanel(parts: Parts): HTMLElement {
    const { session, actions } = parts;
    const { labelMap: labels, store } = session;
    const table = h('table', { class: 'labels' });
    const open = button(
        'Labels…',
        () => file.click(),
        'a label map for this scan (NRRD, NIfTI, MetaImage), or a table of names (.ctbl, .csv)',
    );
    const file = h('input', {
        type: 'file',
        accept: '.nrrd,.nii,.gz,.mha,.ctbl,.csv,.txt',
        hidden: true,
        'aria-label': 'labels file',
        onchange: () => {
            const chosen = file.files?.[0];
            if (chosen) void actions.openLabels(chosen);
            file.value = '';
        },
    });
    const hint = h(
        'small',
        { class: 'quiet' },
        'A label map is drawn over the scan and moves with the tissue.',
    );
    const all = h(
        'div',
        { class: 'row' },
        button('Show all', () => labels.showAll(true)),
        button('Hide all', () => labels.showAll(false)),
    );
    const opacity = parts.number('labels', 'opacity', {
        label: 'Opacity of labels',
        unit: '',
        low: 0,
        high: 1,
        step: 0.05,
    });
    const outline = parts.add(
        checkbox(
            'outlines in the sections',
            () => parts.state.labels.outline,
            (on) => store.set({ labels: { outline: on } }),
        ),
    );
    store.watch(
        ({ labels: { list, looks, names } }) => [list, looks, names],
        (list, _looks, _names) => {
            const focus = document.activeElement?.getAttribute('aria-label');
            const inside = table.contains(document.activeElement);
            table.replaceChildren(head(), ...list.map((label) => row(parts, label)));
            if (inside && focus)
                table.querySelector<HTMLElement>(`[aria-label="${CSS.escape(focus)}"]`)?.focus();
            const none = !list.length;
            table.hidden = opacity.hidden = outline.hidden = all.hidden = none;
            hint.hidden = !none;
        },
    );
    const element = section(
        'Labels',
        false,
        h('div', { class: 'row' }, open, file),
        hint,
        opacity,
        outline,
        all,
        h('div', { class: 'scroll', tabindex: '0', role: 'group', 'aria-label': 'Labels' }, table),
    );
    store.watch(
        ({ link }) => [link],
        ({ status, features, role, transfer }) => {
            element.hidden = status === 'open' && !features.includes('labels');
            open.disabled = transfer !== '' || (role === 'view' && !store.state.labels.file);
        },
    );
    return element;
}

const head = (): HTMLElement =>
    h(
        'tr',
        {},
        h('th', { scope: 'col' }, 'label'),
        ...kColumns.map(({ head: text, hint }) => h('th', { scope: 'col', title: hint }, text)),
    );

function row(parts: Parts, label: Label): HTMLElement {
    const { labelMap: labels } = parts.session;
    const state = parts.state.labels;
    const name = nameOf(state, label);
    const look = lookOf(state, label);
    const swatch = h('i', { 'aria-hidden': 'true' });
    swatch.style.background = cssOf(label.colour);
    const go = button(name, () => labels.goTo(label), `value ${label.value}; go there`);
    return h(
        'tr',
        {},
        h('th', { scope: 'row' }, swatch, go),
        ...kColumns.map(({ key, head: text }) => {
            const tick = h('input', {
                type: 'checkbox',
                'aria-label': `${text} ${name}`,
                onchange: () => labels.look(label, { [key]: tick.checked }),
            });
            tick.checked = look[key];
            return h('td', {}, tick);
        }),
    );
}
