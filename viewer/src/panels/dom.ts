// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Creates elements and controls, without a framework.

import { fixed, roundTo } from '../maths/steps.ts';
import type { Limits } from '../state/units.ts';

type Child = Node | string | undefined | false;
type Attributes = Record<string, string | boolean | ((event: Event) => void)>;

/// Creates an element. Functions are listeners, with "on" before the event's name; true is an
/// attribute without a value.
export function h<K extends keyof HTMLElementTagNameMap>(
    tag: K,
    attributes: Attributes = {},
    ...children: Child[]
): HTMLElementTagNameMap[K] {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
        if (typeof value === 'function') element.addEventListener(name.slice(2), value);
        else if (value === true) element.setAttribute(name, '');
        else if (value !== false) element.setAttribute(name, value);
    }
    for (const child of children) if (child) element.append(child);
    return element;
}

const kDigits = 4; // that a number field has room for
let nextId = 1;

export interface SliderSettings extends Limits {
    label: string;
    /// Present limits, where they change.
    limits?: () => Limits;
    value: () => number;
    /// Called while the slider moves.
    input: (value: number) => void;
    /// Called before and after a gesture.
    begin?: () => void;
    end?: () => void;
    /// The position on the slider is the square root of the value, for sizes.
    curved?: boolean;
    hint?: string;
}

export interface Control {
    readonly element: HTMLElement;
    refresh(): void;
}

/// Creates a slider with a number field, which may exceed the slider's range.
export function slider(s: SliderSettings): Control {
    const id = `c${nextId++}`;
    const root = (v: number): number => (s.curved ? Math.sqrt(Math.max(v, 0)) : v);
    const back = (v: number): number => (s.curved ? v * v : v);
    let limits: Limits | undefined; // as they are shown
    const rounded = (v: number): number => roundTo(v, limits!.step);
    const text = (v: number): string => String(Number(fixed(v, limits!.step)));
    const range = h('input', { type: 'range', id });
    const unit = h('span', { class: 'unit' });
    const number = h('input', {
        type: 'number',
        'aria-label': `${s.label}, number`,
        // Keys are commands again after a number.
        onkeydown: (event) => {
            const { key } = event as KeyboardEvent;
            if (key === 'Escape') number.value = text(s.value());
            if (key === 'Enter' || key === 'Escape') number.blur();
        },
    });
    let open = false;
    const begin = (): void => {
        if (!open) s.begin?.();
        open = true;
    };
    const end = (): void => {
        if (open) s.end?.();
        open = false;
    };
    range.addEventListener('input', () => {
        begin();
        s.input(rounded(back(Number(range.value))));
    });
    range.addEventListener('change', end);
    number.addEventListener('change', () => {
        const value = Number(number.value);
        if (number.value !== '' && Number.isFinite(value)) {
            begin();
            s.input(value);
            end();
        }
        refresh();
    });
    const adjust = (next: Limits): void => {
        const keys = ['unit', 'low', 'high', 'step'] as const;
        if (limits && keys.every((key) => limits![key] === next[key])) return;
        limits = next;
        range.min = String(root(next.low));
        range.max = String(root(next.high));
        range.step = s.curved ? 'any' : String(next.step);
        number.step = String(next.step);
        unit.textContent = next.unit;
    };
    const refresh = (): void => {
        adjust(s.limits?.() ?? s);
        const value = s.value();
        const shown = text(value);
        if (document.activeElement !== number) number.value = shown;
        number.classList.toggle('long', shown.replace(/\D/g, '').length > kDigits);
        if (!open) range.value = String(root(value)); // else the user moves it
        range.setAttribute('aria-valuetext', `${shown} ${limits!.unit}`.trim());
    };
    refresh();
    const element = h(
        'div',
        { class: 'slider', ...(s.hint ? { title: s.hint } : {}) },
        h('label', { for: id }, s.label),
        range,
        h('span', { class: 'number' }, number, unit),
    );
    return { element, refresh };
}

/// Creates radio buttons.
export function choice<T extends string>(
    label: string,
    options: readonly { value: T; text: string; hint?: string }[],
    value: () => T,
    pick: (value: T) => void,
): Control {
    const name = `c${nextId++}`;
    const inputs = options.map((o) =>
        h('input', { type: 'radio', name, value: o.value, onchange: () => pick(o.value) }),
    );
    const refresh = (): void => {
        for (const input of inputs) input.checked = input.value === value();
    };
    refresh();
    const element = h(
        'fieldset',
        { class: 'choice' },
        h('legend', {}, label),
        h(
            'div',
            {},
            ...options.map((o, i) =>
                h('label', o.hint ? { title: o.hint } : {}, inputs[i]!, h('span', {}, o.text)),
            ),
        ),
    );
    return { element, refresh };
}

export function checkbox(
    label: string,
    value: () => boolean,
    pick: (on: boolean) => void,
    hint = '',
): Control {
    const input = h('input', { type: 'checkbox', onchange: () => pick(input.checked) });
    const refresh = (): void => {
        input.checked = value();
    };
    refresh();
    const element = h('label', { class: 'check', ...(hint ? { title: hint } : {}) }, input, label);
    return { element, refresh };
}

/// Creates a list that calls back with the chosen value and goes on showing its label.
export function menu<T>(
    label: string,
    options: readonly { text: string; value: T }[],
    pick: (value: T) => void,
): HTMLSelectElement {
    const select = h(
        'select',
        {
            'aria-label': label,
            onchange: () => {
                const option = options[Number(select.value)];
                if (option) pick(option.value);
                select.value = '';
            },
        },
        h('option', { value: '', disabled: true, selected: true }, label),
        ...options.map((o, i) => h('option', { value: String(i) }, o.text)),
    );
    return select;
}

export const button = (text: string, run: () => void, hint = ''): HTMLButtonElement =>
    h('button', { type: 'button', onclick: run, ...(hint ? { title: hint } : {}) }, text);

export function svg(name: string, attributes: Record<string, string | number> = {}): SVGElement {
    const element = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
    return element;
}
