// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What a hand does with a tool: press, move, lift. A stroke follows the pointer as fast as the
// server answers: one command is under way at a time, and what the pointer did meanwhile goes into
// the next. So a slow server sees fewer and longer steps, never a queue.

import { along, mul, norm, sub, type Vec3 } from '../maths/vec.ts';
import type { Connection } from '../net/connection.ts';
import type { Answer, Command, Done } from '../net/protocol.ts';
import { pushOrSlide } from '../state/state.ts';
import type { Store } from '../state/store.ts';
import type { ToolKind } from '../views/instruments.ts';

let nextStroke = 1 + Math.floor(Math.random() * 2 ** 30);

/// A number for commands that are one step of undo.
export const newStroke = (): number => nextStroke++;

export interface Stroke {
    /// The pointer is at another place [mm, LPS].
    to(place: Vec3): void;
    /// @returns a promise that is kept when the server has done everything
    end(): Promise<void>;
    /// Where the tool is now, to be drawn; a line for a cut.
    readonly path: readonly Vec3[];
    readonly radius: number;
    readonly kind: ToolKind;
    readonly closed?: boolean; ///< it holds tissue
}

/// Tells the store what came of a command. Cut links don't show before something moves: that they
/// are cut has to be said.
export function note(store: Store, answer: Answer | undefined): void {
    if (answer?.t !== 'done') return;
    let outcome = answer.message ?? '';
    if (answer.cut_links !== undefined) outcome ||= `${answer.cut_links} links cut`;
    if (answer.status && answer.status !== 'applied')
        outcome ||= `${answer.status} by ${answer.limited_by ?? 'something'}`;
    store.set({ tool: { outcome } });
}

/// Takes the newest target along, one command after the other.
abstract class Follower implements Stroke {
    protected target: Vec3;
    path: readonly Vec3[];
    private busy: Promise<void> | undefined;

    constructor(
        protected readonly connection: Connection,
        protected readonly store: Store,
        start: Vec3,
        readonly radius: number,
        readonly kind: ToolKind,
    ) {
        this.target = start;
        this.path = [start];
    }

    to(place: Vec3): void {
        this.target = place;
        this.busy ??= this.follow().finally(() => {
            this.busy = undefined;
        });
    }

    async end(): Promise<void> {
        await this.busy;
        await this.finish();
        this.store.set({ hands: { force: 0 } });
    }

    /// Makes a part of the way to the target. @returns whether something is left to do
    protected abstract advance(): Promise<boolean>;
    protected async finish(): Promise<void> {}

    protected async ask(command: Command): Promise<Done | undefined> {
        const answer = await this.connection.ask(command);
        note(this.store, answer);
        return answer?.t === 'done' ? answer : undefined;
    }

    private async follow(): Promise<void> {
        while (await this.advance());
    }
}

const kCellStep = 1; // [mm]
export const kLeastCarving = 0.5; // radius; a cell can't be carved [mm]
const kLeast = 0.02; // shorter motions are left to the next one [mm]

/// Part of the way from a to b, at most so long.
function stepTo(a: Vec3, b: Vec3, most: number): Vec3 | undefined {
    const way = sub(b, a);
    const length = norm(way);
    if (length < kLeast) return undefined;
    return length > most ? mul(most / length, way) : way;
}

/// A sphere that takes tissue along, or that tissue slides off.
export class PushStroke extends Follower {
    private place: Vec3;
    private readonly stroke = newStroke();
    private readonly verb: 'push' | 'slide';

    constructor(connection: Connection, store: Store, start: Vec3) {
        super(connection, store, start, store.state.tool.radius, 'ball');
        this.place = start;
        const slides = store.state.tool.slide && this.radius > 0;
        this.verb = pushOrSlide(store.state, slides);
    }

    protected async advance(): Promise<boolean> {
        // The tool of radius 0 takes the eight elements of its cell, and steps of a millimetre.
        const push = stepTo(this.place, this.target, this.radius || kCellStep);
        if (!push) return false;
        const done = await this.ask({
            do: this.verb,
            point: this.place,
            push,
            radius: this.radius,
            stroke: this.stroke,
        });
        if (!done) return false;
        const fraction = done.grabbed_elements === 0 ? 1 : (done.step_fraction ?? 1);
        this.place = done.end ?? along(this.place, fraction, push);
        this.path = [this.place];
        if (fraction < 1) this.target = this.place; // what stops the tool stops the stroke
        return fraction === 1;
    }

    protected override async finish(): Promise<void> {
        await this.ask({ do: 'release' });
    }
}

/// Takes hold of tissue and leads it.
export class GrabStroke extends Follower {
    private readonly start: Vec3;
    private offset: Vec3 = [0, 0, 0];
    private held: boolean | undefined;

    get closed(): boolean {
        return this.held === true;
    }

    constructor(connection: Connection, store: Store, start: Vec3) {
        super(connection, store, start, store.state.tool.radius, 'grasper');
        this.start = start;
    }

    protected async advance(): Promise<boolean> {
        if (this.held === undefined) {
            const done = await this.ask({ do: 'grab', point: this.start, radius: this.radius });
            this.held = (done?.grabbed_elements ?? 0) > 0;
            if (!this.held) this.store.set({ tool: { outcome: 'nothing to hold here' } });
        }
        const offset = sub(this.target, this.start);
        if (!this.held || norm(sub(offset, this.offset)) < kLeast) return false;
        const done = await this.ask({ do: 'drag', offset });
        if (!done) return false;
        this.offset = offset;
        this.path = [along(this.start, 1, offset)];
        return true;
    }

    protected override async finish(): Promise<void> {
        if (this.held) await this.ask({ do: 'let_go' });
    }
}

/// Takes tissue out along the pointer's way.
export class CarveStroke extends Follower {
    private place: Vec3;
    private begun = false;
    private readonly stroke = newStroke();

    constructor(connection: Connection, store: Store, start: Vec3) {
        super(connection, store, start, Math.max(store.state.tool.radius, kLeastCarving), 'scoop');
        this.place = start;
    }

    protected async advance(): Promise<boolean> {
        const way = stepTo(this.place, this.target, Infinity);
        if (this.begun && !way) return false;
        this.begun = true;
        const to = way ? along(this.place, 1, way) : this.place;
        const done = await this.ask({
            do: 'carve',
            from: this.place,
            to,
            radius: this.radius,
            stroke: this.stroke,
        });
        this.place = to;
        this.path = [to];
        return done !== undefined;
    }
}

const kMostPoints = 500;

/// A line that is drawn first and cut when the pointer is lifted.
export class CutStroke implements Stroke {
    readonly radius = 0;
    readonly kind = 'blade';
    path: Vec3[];

    /// @param direction  where the blade goes from the line, unit
    constructor(
        private readonly connection: Connection,
        private readonly store: Store,
        start: Vec3,
        private readonly direction: Vec3,
        private readonly centred: boolean,
    ) {
        this.path = [start];
    }

    to(place: Vec3): void {
        const last = this.path[this.path.length - 1]!;
        if (norm(sub(place, last)) >= 0.5 && this.path.length < kMostPoints) this.path.push(place);
    }

    async end(): Promise<void> {
        if (this.path.length < 2) return;
        const depth = mul(this.store.state.tool.depth, this.direction);
        // In a section the blade goes as far to its front as to its back; into a wall it starts
        // just before it.
        const shift = this.centred ? -0.5 : -0.15;
        const line = this.path.map((p) => along(p, shift, depth));
        note(this.store, await this.connection.ask({ do: 'cut', line, depth }));
    }
}
