// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One undo for everything. Steps that change the tissue or the threshold are the server's; the
// groups `view`, `sections` and `rendering` are the page's own. Each own step remembers the number
// of server steps before it, which puts both kinds into one order.

import type { State } from './state.ts';
import type { Store } from './store.ts';

type Own = Pick<State, 'view' | 'sections' | 'rendering'>;

interface Step {
    readonly name: string;
    readonly before: Own;
    readonly after: Own;
    readonly serverSteps: number;
}

const kMaxSteps = 200;
const kMergeMs = 700;

const ownOf = ({ view, sections, rendering }: State): Own => ({ view, sections, rendering });

function sameValues<T extends object>(a: T, b: T): boolean {
    return (Object.keys(a) as (keyof T)[]).every((key) => a[key] === b[key]);
}

const same = (a: Own, b: Own): boolean =>
    sameValues(a.view, b.view) &&
    sameValues(a.sections, b.sections) &&
    sameValues(a.rendering, b.rendering);

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
        private readonly server: (step: 'undo' | 'redo') => Promise<void>,
        private readonly now: () => number = () => performance.now(),
    ) {}

    /// Begins a change of the page's own state, of any number of calls of set. Overlapping changes,
    /// as of flying and looking around, are one step.
    begin(): void {
        if (this.open++ === 0) this.before = ownOf(this.store.state);
    }

    /// Ends a change. @param merge  joins it with the last step, if that is recent and of this name
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
        if (this.done.length > kMaxSteps) this.done.shift();
        this.undone = [];
        this.lastName = merge ? name : '';
        this.lastEnd = this.now();
        this.onChange();
    }

    /// Makes a change at once; notches of a wheel in quick succession are one step.
    step(name: string, change: () => void): void {
        this.begin();
        change();
        this.end(name, true);
    }

    /// Forgets all steps, for another scan.
    clear(): void {
        this.done.length = 0;
        this.undone = [];
        this.before = undefined;
        this.open = 0;
        this.lastName = '';
        this.onChange();
    }

    /// Takes back the last step. Quick presses wait for each other: the server's answer tells which
    /// step is the last.
    undo(): Promise<void> {
        return this.next(() => this.undoNow());
    }
    redo(): Promise<void> {
        return this.next(() => this.redoNow());
    }

    private next(step: () => Promise<void> | undefined): Promise<void> {
        this.queue = this.queue.then(step);
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

    /// Names of the next steps to undo and to redo; empty: none.
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
