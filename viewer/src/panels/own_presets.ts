// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The user's own presets beside the built-in ones. They are kept in this browser's storage for all
// scans, and validated when they are loaded.

import type { Memory } from '../net/connection.ts';
import { button, type Control, h } from './dom.ts';

export interface Preset<T> {
    readonly text: string;
    readonly value: T;
}

const kMaxPresets = 50;
const kLongestName = 40;

export class PresetShelf<T> {
    private list: Preset<T>[] = [];
    onChange: () => void = () => {};

    /// @param isValue  validates a stored value
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
                for (const item of stored.slice(0, kMaxPresets) as Partial<Preset<unknown>>[])
                    if (typeof item?.text === 'string' && item.text && this.isValue(item.value))
                        this.list.push({ text: cut(item.text), value: item.value });
        } catch {
            // Invalid JSON counts as an empty list.
        }
        this.onChange();
    }

    /// Saves a preset, replacing one of the same name. @returns an error; undefined: saved
    save(name: string, value: T): string | undefined {
        const text = cut(name.trim());
        if (!text) return 'a preset needs a name';
        const others = this.list.filter((preset) => preset.text !== text);
        if (others.length >= kMaxPresets) return `there are ${kMaxPresets} presets already`;
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
            return 'the browser stores nothing: the preset is lost with the page';
        }
    }
}

const cut = (name: string): string => [...name].slice(0, kLongestName).join('');

/// Creates a list of presets, with controls to save and delete own ones.
/// @param label  "Presets of …"
/// @param builtIn  the present list; another one is another object
export function presetsWithOwn<T>(
    label: string,
    builtIn: () => readonly Preset<T>[],
    shelf: PresetShelf<T>,
    current: () => T,
    pick: (value: T) => void,
    say: (text: string) => void,
): Control {
    const select = h('select', {
        'aria-label': label,
        onchange: () => {
            const [kind, index] = select.value.split(' ');
            const preset = (kind === 'own' ? shelf.presets : given)[Number(index)];
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
        'aria-label': `${label}: name of an own preset`,
        oninput: () => refreshButtons(),
        onkeydown: (event) => {
            if ((event as KeyboardEvent).key !== 'Enter') return;
            save.click();
            name.blur();
        },
    });
    const save = button(
        'Save',
        () => {
            const problem = shelf.save(name.value, current());
            say(problem ?? `preset ${name.value.trim()} saved`);
        },
        'saves the present settings under this name',
    );
    const remove = button(
        'Delete',
        () => {
            shelf.remove(name.value.trim());
            name.value = '';
            refreshButtons();
        },
        'deletes the own preset of this name',
    );
    save.setAttribute('aria-label', `${label}: save as an own preset`);
    remove.setAttribute('aria-label', `${label}: delete the own preset`);
    const options = (list: readonly Preset<T>[], kind: string): HTMLOptionElement[] =>
        list.map((preset, i) => h('option', { value: `${kind} ${i}` }, preset.text));
    const refreshButtons = (): void => {
        const wanted = name.value.trim();
        save.disabled = !wanted;
        remove.disabled = !shelf.presets.some((preset) => preset.text === wanted);
    };
    let given = builtIn();
    const fill = (): void => {
        select.replaceChildren(
            h('option', { value: '', disabled: true, selected: true }, label),
            ...options(given, 'given'),
        );
        if (shelf.presets.length)
            select.append(h('optgroup', { label: 'Own' }, ...options(shelf.presets, 'own')));
        refreshButtons();
    };
    shelf.onChange = fill;
    fill();
    // Changes by other tabs.
    window.addEventListener('storage', (event) => {
        if (event.key === shelf.key) shelf.load();
    });
    const element = h(
        'div',
        { class: 'presets' },
        select,
        h('div', { class: 'row' }, name, save, remove),
    );
    const refresh = (): void => {
        const now = builtIn();
        if (now === given) return;
        given = now;
        fill();
    };
    return { element, refresh };
}
