// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panel of measurements: kinds of marks, the list of marks with values, files, and sizes of the
// lumen at the tip and along the path.

import { type CrossSection, kLumenReach } from '../maths/lumen.ts';
import type { Mark } from '../maths/marks.ts';
import type { VolumeInfo } from '../net/protocol.ts';
import type { LumenAt, Marks } from '../state/state.ts';
import { areaText, lengthText, scaleOf, roundLength } from '../state/units.ts';
import { button, checkbox, h, svg } from './dom.ts';
import { type Parts, section } from './panel_parts.ts';

const kKinds: readonly { kind: Marks['kind']; text: string; title: string }[] = [
    { kind: 'point', text: 'Point', title: 'one click' },
    { kind: 'ruler', text: 'Ruler', title: 'two clicks: a distance' },
    { kind: 'angle', text: 'Angle', title: 'three clicks, the second at the vertex' },
];

export function marksPanel(parts: Parts): HTMLElement {
    const { session, actions } = parts;
    const { marks, store } = session;
    const list = h('ul', { class: 'marks', 'aria-label': 'Marks' });
    const hint = h('small', { class: 'quiet' }, '');
    const save = button(
        'Save .mrk.json',
        () => marks.saveMarkups(),
        'markups for 3D Slicer, at their present positions',
    );
    const table = button('Save .csv', () => marks.saveTable(), 'a table of all points and values');
    const clear = button('Delete all', () => marks.clear());
    const curve = button('Path as curve', () => marks.addPath(), 'adds the path to the marks');
    const kinds = kKinds.map(({ kind, text, title }) => {
        const b = button(text, () => marks.choose(kind), title);
        b.dataset.kind = kind;
        return b;
    });
    store.watch(
        ({ marks: { kind }, tool }) => [kind, tool.name],
        (kind, tool) => {
            for (const b of kinds)
                b.setAttribute(
                    'aria-pressed',
                    String(tool === 'measure' && b.dataset.kind === kind),
                );
        },
    );
    // The list is rebuilt when marks change; values also change with the tissue.
    store.watch(
        ({ marks: { list: all, selected } }) => [all, selected],
        (all, selected) => {
            keepFocus(list, () =>
                list.replaceChildren(...all.map((m) => line(parts, m, selected))),
            );
            save.disabled = table.disabled = clear.disabled = !all.length;
            hint.textContent = all.length
                ? ''
                : 'Choose a kind, then click in a section or on the wall. Marks move with tissue.';
            hint.hidden = all.length > 0;
        },
    );
    store.watch(
        ({ versions, marks: { list: all } }) => [versions.rest, all],
        () => {
            for (const value of list.querySelectorAll<HTMLElement>('output')) {
                const mark = store.state.marks.list.find(({ key }) => key === value.dataset.key);
                if (mark) value.textContent = marks.textOf(mark);
            }
        },
    );
    store.watch(
        ({ way }) => [way.path],
        (path) => {
            curve.disabled = !path;
        },
    );
    const file = h('input', {
        type: 'file',
        accept: '.json,.csv',
        hidden: true,
        'aria-label': 'marks file',
        onchange: () => {
            const chosen = file.files?.[0];
            if (chosen) void actions.openMarks(chosen);
            file.value = '';
        },
    });
    return section(
        'Measure',
        false,
        h('div', { class: 'row' }, ...kinds),
        hint,
        list,
        h('div', { class: 'row' }, save, table),
        h(
            'div',
            { class: 'row' },
            button('Load…', () => file.click(), 'markups of 3D Slicer, or a table'),
            file,
            curve,
            clear,
        ),
        ...lumenControls(parts),
    );
}

/// Changes a list and gives the focus back to the control that had it.
function keepFocus(list: HTMLElement, change: () => void): void {
    const own = document.activeElement as HTMLElement | null;
    const label = own && list.contains(own) ? own.getAttribute('aria-label') : undefined;
    change();
    if (!label) return;
    const again = [...list.querySelectorAll<HTMLElement>('[aria-label]')].find(
        (e) => e.getAttribute('aria-label') === label,
    );
    again?.focus();
}

function line(parts: Parts, mark: Mark, selected: string): HTMLElement {
    const { marks } = parts.session;
    const { key, name, shown } = mark;
    const show = h('input', {
        type: 'checkbox',
        'aria-label': `show ${name}`,
        onchange: () => marks.show(key, show.checked),
    });
    show.checked = shown;
    const text = h('input', {
        type: 'text',
        value: name,
        maxlength: '80',
        'aria-label': `name of ${name}`,
        onchange: () => marks.rename(key, text.value),
    });
    const value = h('output', { 'data-key': key });
    const go = button('→', () => marks.goTo(key), 'go there');
    go.setAttribute('aria-label', `go to ${name}`);
    const remove = button('×', () => marks.remove(key), 'delete');
    remove.setAttribute('aria-label', `delete ${name}`);
    const item = h('li', { class: 'row' }, show, text, value, go, remove);
    item.classList.toggle('chosen', key === selected);
    return item;
}

// --- the lumen

const kHeight = 74; // of the chart [pixels]
const kWidth = 236;
const kLeft = 24; // margins of its axis
const kRight = 2;

function lumenControls(parts: Parts): HTMLElement[] {
    const { session } = parts;
    const { store, lumen, path } = session;
    const numbers = h('dl', { class: 'servo', 'aria-live': 'off' });
    const chart = svg('svg', {
        class: 'chart',
        viewBox: `0 0 ${kWidth} ${kHeight}`,
        role: 'img',
        'aria-label': 'diameter of the lumen along the path',
    }) as SVGSVGElement;
    const summary = h('small', { class: 'quiet' });
    const along = button(
        'Lumen along the path',
        () => lumen.measurePath(),
        'sections perpendicular to the path',
    );
    chart.addEventListener('click', (event) => {
        const box = chart.getBoundingClientRect();
        const { path: way } = store.state.way;
        if (!way) return;
        const x = ((event.clientX - box.left) / box.width) * kWidth;
        const share = (x - kLeft) / (kWidth - kLeft - kRight);
        session.history.step('position', () => path.goTo(share * way.length));
    });
    store.watch(
        ({ lumen: { tip, on } }) => [tip, on],
        (tip, on) => {
            numbers.hidden = !on;
            const { volume } = store.state.scan;
            const isMeasured = tip !== null && tip !== 'open';
            numbers.replaceChildren(...(isMeasured ? rows(tip, volume) : none(tip, volume)));
        },
    );
    store.watch(
        ({ lumen: { along: sizes, share, step }, way, shared }) => [
            sizes,
            share,
            way.path,
            way.position,
            step === shared?.step,
        ],
        (sizes, share, way, position, isPresent) => {
            along.disabled = !way || share < 1;
            chart.style.display = sizes.length && share === 1 ? '' : 'none';
            summary.textContent = share < 1 ? `measuring: ${Math.round(100 * share)} %` : '';
            if (!sizes.length || share < 1 || !way) return;
            const { volume } = store.state.scan;
            const text = summaryOf(sizes, volume) + (isPresent ? '' : '; before the last motion');
            summary.textContent = text;
            chart.setAttribute('aria-label', `Diameter of the lumen along the path. ${text}`);
            chart.replaceChildren(...chartOf(sizes, way.length, position, volume));
        },
    );
    const tip = parts.add(
        checkbox(
            'lumen at the tip',
            () => parts.state.lumen.on,
            (on) => store.set({ lumen: { on } }),
            'section perpendicular to the view',
        ),
    );
    const frame = h('div', {}, chart as unknown as HTMLElement);
    return [tip, numbers, h('div', { class: 'row' }, along), frame, summary];
}

const pair = (name: string, text: string): HTMLElement[] => [h('dt', {}, name), h('dd', {}, text)];

const none = (tip: 'open' | null, scan: VolumeInfo | null): HTMLElement[] => {
    const most = lengthText(scan, 2 * kLumenReach * scaleOf(scan), 1);
    return pair('Lumen', tip === 'open' ? `open: wider than ${most} mm` : 'the tip is in tissue');
};

function rows(tip: CrossSection, scan: VolumeInfo | null): HTMLElement[] {
    const mm = (length: number): string => lengthText(scan, length);
    return [
        ...pair('Area', `${areaText(scan, tip.area)} mm²`),
        ...pair('Diameter by area', `${mm(tip.equivalent)} mm`),
        ...pair('Largest circle', `${mm(tip.inscribed)} mm`),
        ...pair('Widths', `${mm(tip.narrow)}…${mm(tip.wide)} mm`),
    ];
}

/// Line with the smallest and the mean diameter.
export function summaryOf(sizes: readonly LumenAt[], scan: VolumeInfo | null): string {
    const mm = (length: number): string => lengthText(scan, length);
    const known = sizes.flatMap(({ way, size }) => (size ? [{ way, size }] : []));
    if (!known.length) return 'the lumen is open everywhere';
    const least = known.reduce((a, b) => (b.size.equivalent < a.size.equivalent ? b : a));
    const mean = known.reduce((sum, { size }) => sum + size.equivalent, 0) / known.length;
    const open = sizes.length - known.length;
    return (
        `diameter at least ${mm(least.size.equivalent)} mm ` +
        `(${areaText(scan, least.size.area, 1)} mm², at ${lengthText(scan, least.way, 1)} mm), ` +
        `mean ${mm(mean)} mm` +
        (open ? `; open at ${open} of ${sizes.length} points` : '')
    );
}

/// Curves of the diameters: of the same area strong, of the largest circle faint.
function chartOf(
    sizes: readonly LumenAt[],
    length: number,
    position: number,
    scan: VolumeInfo | null,
): SVGElement[] {
    const known = sizes.flatMap(({ size }) => (size ? [size.equivalent] : []));
    const top = Math.max(...known, roundLength(scan, 1)) * 1.1;
    const left = kLeft;
    const x = (way: number): number => left + ((kWidth - left - kRight) * way) / length;
    const y = (mm: number): number => kHeight - 14 - ((kHeight - 22) * mm) / top;
    const curve = (kind: string, value: 'equivalent' | 'inscribed'): SVGElement => {
        let pen = 'M';
        const parts = sizes.map(({ way, size }) => {
            if (!size) {
                pen = 'M';
                return '';
            }
            const part = `${pen}${x(way).toFixed(1)} ${y(size[value]).toFixed(1)}`;
            pen = 'L';
            return part;
        });
        return svg('path', { class: kind, d: parts.join('') });
    };
    const label = (at: number, up: number, words: string, anchor: string): SVGElement => {
        const element = svg('text', { x: at, y: up, 'text-anchor': anchor });
        element.textContent = words;
        return element;
    };
    return [
        svg('path', { class: 'axis', d: `M${left} 4V${y(0)}H${kWidth - kRight}` }),
        label(left - 3, y(top / 1.1) + 4, lengthText(scan, top / 1.1, 1), 'end'),
        label(left - 3, y(0), '0', 'end'),
        label(left, kHeight - 2, 'mm', 'end'),
        label(kWidth - 2, kHeight - 2, `${lengthText(scan, length, 1)} mm`, 'end'),
        curve('circle', 'inscribed'),
        curve('same', 'equivalent'),
        svg('path', { class: 'here', d: `M${x(position)} 4V${y(0)}` }),
    ];
}
