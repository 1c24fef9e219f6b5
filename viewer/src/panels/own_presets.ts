// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Presets with names that the user gave, beside the built-in ones. They are kept in this browser,
// for all scans; what a browser's storage holds may have been changed by anybody, so it is checked.

import type { Memory } from '../net/connection.ts';
import { button, type Control, h } from './dom.ts';

export interface Preset<T> {
    readonly text: string;
    readonly value: T;
}

const kMostPresets = 50;
const kLongestName = 40;

export class PresetShelf<T> {
    private list: Preset<T>[] = [];
    onChange: () => void = () => {};

    /// @param isValue  whether something that was stored is a value
    constructor(
        private readonly memory: Memory,
        readonly key: string,
        private readonly isValue: (value: unknown) => value is T,
    ) {
        this.load();
    }

    get presets(): readonly Preset<T>[] {
        return this.list;
    }

    load(): void {
        this.list = [];
        try {
            const stored: unknown = JSON.parse(this.memory.getItem(this.key) ?? '[]');
            if (Array.isArray(stored))
                for (const item of stored.slice(0, kMostPresets) as Partial<Preset<unknown>>[])
                    if (typeof item?.text === 'string' && item.text && this.isValue(item.value))
                        this.list.push({ text: cut(item.text), value: item.value });
        } catch {
            // As if nothing had been stored.
        }
        this.onChange();
    }

    /// Takes the place of one with the same name. @returns why not, if not
    save(name: string, value: T): string | undefined {
        const text = cut(name.trim());
        if (!text) return 'a preset needs a name';
        const others = this.list.filter((preset) => preset.text !== text);
        if (others.length >= kMostPresets) return `there are ${kMostPresets} presets already`;
        this.list = [...others, { text, value }].sort((a, b) => a.text.localeCompare(b.text));
        return this.keep();
    }

    remove(name: string): void {
        this.list = this.list.filter((preset) => preset.text !== name);
        this.keep();
    }

    private keep(): string | undefined {
        this.onChange();
        try {
            this.memory.setItem(this.key, JSON.stringify(this.list));
            return undefined;
        } catch {
            return 'the browser keeps nothing: the preset is gone with the page';
        }
    }
}

const cut = (name: string): string => [...name].slice(0, kLongestName).join('');

/// A list to take a preset from, and what makes and deletes own ones.
/// @param label  "Presets of …"
export function presetsWithOwn<T>(
    label: string,
    builtIn: readonly Preset<T>[],
    shelf: PresetShelf<T>,
    current: () => T,
    pick: (value: T) => void,
    say: (text: string) => void,
): Control {
    const select = h('select', {
        'aria-label': label,
        onchange: () => {
            const [kind, index] = select.value.split(' ');
            const preset = (kind === 'own' ? shelf.presets : builtIn)[Number(index)];
            select.value = '';
            if (!preset) return;
            if (kind === 'own') name.value = preset.text;
            refreshButtons();
            pick(preset.value);
        },
    });
    const name = h('input', {
        type: 'text',
        maxlength: String(kLongestName),
        placeholder: 'name',
        'aria-label': `${label}: name of an own one`,
        oninput: () => refreshButtons(),
        onkeydown: (event) => {
            if ((event as KeyboardEvent).key === 'Enter') save.click();
        },
    });
    const save = button(
        'Save',
        () => {
            const problem = shelf.save(name.value, current());
            say(problem ?? `preset ${name.value.trim()} saved`);
        },
        'what is set now becomes a preset of that name',
    );
    const remove = button(
        'Delete',
        () => {
            shelf.remove(name.value.trim());
            name.value = '';
            refreshButtons();
        },
        'the own preset of that name',
    );
    save.setAttribute('aria-label', `${label}: save as an own one`);
    remove.setAttribute('aria-label', `${label}: delete the own one`);
    const options = (list: readonly Preset<T>[], kind: string): HTMLOptionElement[] =>
        list.map((preset, i) => h('option', { value: `${kind} ${i}` }, preset.text));
    const refreshButtons = (): void => {
        const wanted = name.value.trim();
        save.disabled = !wanted;
        remove.disabled = !shelf.presets.some((preset) => preset.text === wanted);
    };
    const fill = (): void => {
        select.replaceChildren(
            h('option', { value: '', disabled: true, selected: true }, label),
            ...options(builtIn, 'given'),
        );
        if (shelf.presets.length)
            select.append(h('optgroup', { label: 'Own' }, ...options(shelf.presets, 'own')));
        refreshButtons();
    };
    shelf.onChange = fill;
    fill();
    // Another tab may have changed them.
    window.addEventListener('storage', (event) => {
        if (event.key === shelf.key) shelf.load();
    });
    const element = h(
        'div',
        { class: 'presets' },
        select,
        h('div', { class: 'row' }, name, save, remove),
    );
    return { element, refresh: () => {} };
}
