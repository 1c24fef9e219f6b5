// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One undo for everything. Steps that change the tissue or the threshold are the server's; window,
// camera and sections are the page's own. Each own step remembers how many server steps there were
// before it, which puts both kinds into one order.

import type { State, Store } from './store.ts';

const kOwn = [
    'window',
    'level',
    'camera',
    'cursor',
    'sections',
    'orbit',
    'outside',
    'fluoroscopy',
    'fieldOfView',
    'barrel',
    'fog',
] as const;
type Own = Pick<State, (typeof kOwn)[number]>;

interface Step {
    readonly name: string;
    readonly before: Own;
    readonly after: Own;
    readonly serverSteps: number;
}

const kMostSteps = 200;
const kMergeMs = 700;

const ownOf = (state: State): Own =>
    Object.fromEntries(kOwn.map((key) => [key, state[key]])) as unknown as Own;

const same = (a: Own, b: Own): boolean => kOwn.every((key) => a[key] === b[key]);

export class History {
    private readonly done: Step[] = [];
    private undone: Step[] = [];
    private before: Own | undefined;
    private open = 0; // changes that have begun
    private lastName = '';
    private lastEnd = -Infinity;
    private queue: Promise<void> = Promise.resolve();
    onChange: () => void = () => {};

    constructor(
        private readonly store: Store,
        private readonly server: (what: 'undo' | 'redo') => Promise<void>,
        private readonly now: () => number = () => performance.now(),
    ) {}

    /// A change of the page's own state begins; it may take many calls of set. Changes that
    /// overlap, as flying and looking around do, are one step.
    begin(): void {
        if (this.open++ === 0) this.before = ownOf(this.store.state);
    }

    /// @param merge  with the step before, if that has the same name and was just now
    end(name: string, merge = false): void {
        if (this.open > 0 && --this.open === 0) this.close(name, merge);
    }

    private close(name: string, merge: boolean): void {
        const before = this.before;
        this.before = undefined;
        this.open = 0;
        const after = ownOf(this.store.state);
        if (!before || same(before, after)) return;
        const serverSteps = this.store.state.shared?.undo.steps ?? 0;
        const last = this.done[this.done.length - 1];
        const merges =
            merge &&
            last?.name === name &&
            last.serverSteps === serverSteps &&
            this.lastName === name &&
            this.now() - this.lastEnd < kMergeMs;
        if (merges) this.done[this.done.length - 1] = { ...last, after };
        else this.done.push({ name, before, after, serverSteps });
        if (this.done.length > kMostSteps) this.done.shift();
        this.undone = [];
        this.lastName = merge ? name : '';
        this.lastEnd = this.now();
        this.onChange();
    }

    /// The whole of a change at once; notches of a wheel in quick succession are one step.
    step(name: string, change: () => void): void {
        this.begin();
        change();
        this.end(name, true);
    }

    /// Another scan: what was done to the one before is no more.
    clear(): void {
        this.done.length = 0;
        this.undone = [];
        this.before = undefined;
        this.open = 0;
        this.lastName = '';
        this.onChange();
    }

    /// Takes back the last step. Quick presses wait for each other: which step is the last is only
    /// known when the server has said what is left.
    undo(): Promise<void> {
        return this.next(() => this.undoNow());
    }
    redo(): Promise<void> {
        return this.next(() => this.redoNow());
    }

    private next(what: () => Promise<void> | undefined): Promise<void> {
        this.queue = this.queue.then(what);
        return this.queue;
    }

    private undoNow(): Promise<void> | undefined {
        if (this.before) this.close('view', false);
        const steps = this.store.state.shared?.undo.steps ?? 0;
        const own = this.done[this.done.length - 1];
        if (!own || own.serverSteps < steps) return steps > 0 ? this.server('undo') : undefined;
        this.done.pop();
        this.undone.push(own);
        this.lastName = '';
        this.store.set(own.before);
        return undefined;
    }

    private redoNow(): Promise<void> | undefined {
        const shared = this.store.state.shared;
        const own = this.undone[this.undone.length - 1];
        const ownIsNext = own && own.serverSteps <= (shared?.undo.steps ?? 0);
        if (own && (ownIsNext || !shared?.redo.steps)) {
            this.undone.pop();
            this.done.push(own);
            this.store.set(own.after);
            return undefined;
        }
        return shared?.redo.steps ? this.server('redo') : undefined;
    }

    /// What the next undo and redo take back or do again; empty where there is nothing.
    names(): { undo: string; redo: string } {
        const shared = this.store.state.shared;
        const own = this.done[this.done.length - 1];
        const again = this.undone[this.undone.length - 1];
        const steps = shared?.undo.steps ?? 0;
        const undo = own && own.serverSteps >= steps ? own.name : (shared?.undo.next ?? '');
        const redo =
            again && (again.serverSteps <= steps || !shared?.redo.steps)
                ? again.name
                : (shared?.redo.next ?? '');
        return { undo, redo };
    }
}
