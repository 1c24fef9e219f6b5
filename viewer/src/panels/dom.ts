// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Creates elements and controls, without a framework.

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

let nextId = 1;

export interface SliderSettings {
    label: string;
    unit: string;
    low: number;
    high: number;
    step: number;
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
    const rounded = (v: number): number => {
        const digits = Math.max(0, Math.ceil(-Math.log10(s.step)));
        return Number((Math.round(v / s.step) * s.step).toFixed(digits));
    };
    const range = h('input', {
        type: 'range',
        id,
        min: String(root(s.low)),
        max: String(root(s.high)),
        step: s.curved ? 'any' : String(s.step),
    });
    const number = h('input', {
        type: 'number',
        step: String(s.step),
        'aria-label': `${s.label}, number`,
        // Keys are commands again after a number.
        onkeydown: (event) => {
            if ((event as KeyboardEvent).key === 'Enter') number.blur();
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
    const refresh = (): void => {
        const value = s.value();
        if (document.activeElement !== number) number.value = String(rounded(value));
        if (!open) range.value = String(root(value)); // else the user moves it
        range.setAttribute('aria-valuetext', `${rounded(value)} ${s.unit}`);
    };
    refresh();
    const element = h(
        'div',
        { class: 'slider', ...(s.hint ? { title: s.hint } : {}) },
        h('label', { for: id }, s.label),
        range,
        h('span', { class: 'number' }, number, h('span', { class: 'unit' }, s.unit)),
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
