// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One undo for everything. Steps that change the tissue or the threshold are the server's; the
// groups `view`, `sections` and `rendering` and the marks are the page's own. Each own step
// remembers the number of server steps before it, which puts both kinds into one order. Marks are
// shared with other clients, so a step takes back its own changes of them, and none of the changes
// since.

import { type Mark, patched } from '../maths/marks.ts';
import type { State } from './state.ts';
import type { Store } from './store.ts';

type Own = Pick<State, 'view' | 'sections' | 'rendering'> & { readonly marks: readonly Mark[] };

interface Step {
    readonly name: string;
    readonly before: Own;
    readonly after: Own;
    readonly serverSteps: number;
}

/// Step of the server by which a page sets a fresh scan's defaults. As the first step it is not
/// undone.
export const kDefaultsStep = 'materials';

const kMaxSteps = 200;
const kMergeMs = 700;

const redoable = ({ shared, replay }: State): number =>
    replay.isOn ? 0 : (shared?.redo.steps ?? 0);

/// Number of the server's steps that the user can undo.
function undoable({ shared, replay }: State): number {
    if (replay.isOn) return 0; // they are part of the recorded session
    const { steps, next } = shared?.undo ?? { steps: 0, next: '' };
    const isRound = shared?.materials?.limits === 'rounded';
    const isDefaults = steps === 1 && next === kDefaultsStep && isRound;
    return isDefaults ? 0 : steps;
}

const ownOf = ({ view, sections, rendering, marks }: State): Own => ({
    view,
    sections,
    rendering,
    marks: marks.list,
});

function sameValues<T extends object>(a: T, b: T): boolean {
    return (Object.keys(a) as (keyof T)[]).every((key) => a[key] === b[key]);
}

const same = (a: Own, b: Own): boolean =>
    sameValues(a.view, b.view) &&
    sameValues(a.sections, b.sections) &&
    sameValues(a.rendering, b.rendering) &&
    a.marks === b.marks;

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
        const serverSteps = undoable(this.store.state);
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
        const steps = undoable(this.store.state);
        const own = this.done[this.done.length - 1];
        if (!own || own.serverSteps < steps) return steps > 0 ? this.undoServer() : undefined;
        this.done.pop();
        this.undone.push(own);
        this.lastName = '';
        this.restore(own.after, own.before);
        return undefined;
    }

    /// Undoes a step of the server. Springing back after a push is one with it.
    private async undoServer(): Promise<void> {
        const { shared } = this.store.state;
        const springs = shared?.relaxing && shared.undo.next === 'relax';
        const wantsDefaults = shared?.undo.next === kDefaultsStep;
        await this.server('undo');
        if (springs && undoable(this.store.state) > 0) await this.server('undo');
        // The server drops an open step that has moved nothing, and takes the one before it.
        const { undo, redo } = this.store.state.shared ?? shared!;
        if (!wantsDefaults && !undo.steps && redo.next === kDefaultsStep) await this.server('redo');
    }
    private async redoServer(): Promise<void> {
        await this.server('redo');
        const { shared } = this.store.state;
        if (shared?.relaxing && shared.redo.next === 'relax') await this.server('redo');
    }

    private redoNow(): Promise<void> | undefined {
        const steps = redoable(this.store.state);
        const own = this.undone[this.undone.length - 1];
        const ownIsNext = own && own.serverSteps <= undoable(this.store.state);
        if (own && (ownIsNext || !steps)) {
            this.undone.pop();
            this.done.push(own);
            this.restore(own.before, own.after);
            return undefined;
        }
        return steps ? this.redoServer() : undefined;
    }

    private restore(from: Own, { view, sections, rendering, marks }: Own): void {
        const list = patched(this.store.state.marks.list, from.marks, marks);
        this.store.set({ view, sections, rendering, marks: { list } });
    }

    /// Names of the next steps to undo and to redo; empty: none.
    names(): { undo: string; redo: string } {
        const shared = this.store.state.shared;
        const own = this.done[this.done.length - 1];
        const again = this.undone[this.undone.length - 1];
        const steps = undoable(this.store.state);
        const ownIsLast = own && own.serverSteps >= steps;
        const undo = ownIsLast ? own.name : steps > 0 ? shared!.undo.next : '';
        const redo =
            again && (again.serverSteps <= steps || !redoable(this.store.state))
                ? again.name
                : redoable(this.store.state)
                  ? shared!.redo.next
                  : '';
        return { undo, redo };
    }
}
