// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Holds the state and reports its changes. Views, panels and tools read it here and keep no copies.

import type { State } from './state.ts';

/// Values to change, by group; `shared` is replaced as a whole.
export type Patch = {
    readonly [G in keyof State]?: G extends 'shared' ? State[G] : Partial<State[G]>;
};

export type Listener = (state: State, before: State) => void;

type Values = Readonly<Record<string, unknown>>;

export class Store {
    private current: State;
    private readonly listeners: Listener[] = [];

    constructor(initial: State) {
        this.current = initial;
    }

    get state(): State {
        return this.current;
    }

    /// Changes values and calls the listeners. A group without changes remains the same object.
    set(patch: Patch): void {
        const before = this.current;
        const groups: Record<string, unknown> = {};
        for (const [name, given] of Object.entries(patch) as [keyof State, Values][]) {
            const group = before[name] as unknown as Values;
            if (name === 'shared') groups[name] = given;
            else if (Object.entries(given).some(([key, value]) => group[key] !== value))
                groups[name] = { ...group, ...given };
        }
        if (Object.entries(groups).every(([name, group]) => before[name as keyof State] === group))
            return;
        this.current = { ...before, ...groups };
        for (const listener of this.listeners) listener(this.current, before);
    }

    /// Calls back after each change.
    listen(listener: Listener): void {
        this.listeners.push(listener);
    }

    /// Calls back now and whenever one of the parts has become another value or group.
    ///
    ///   store.watch(({ link, tool }) => [link, tool], (link, tool) => …);
    watch<T extends unknown[] | []>(
        parts: (state: State) => T,
        react: (...values: NoInfer<T>) => void,
    ): void {
        let last = parts(this.current);
        react(...last);
        this.listen((state) => {
            const now = parts(state);
            if (now.every((part, i) => part === last[i])) return;
            last = now;
            react(...now);
        });
    }
}
