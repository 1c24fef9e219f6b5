// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Strokes of a tool: press, move, lift. A stroke follows the pointer at the server's pace: one
// command is under way at a time, and the next one covers the motion since. A slow server gets
// fewer and longer steps, never a queue.

import { isWithin } from '../maths/grid.ts';
import { along, mul, norm, sub, type Vec3 } from '../maths/vec.ts';
import type { Connection } from '../net/connection.ts';
import { type Command, type Done, gridOf } from '../net/protocol.ts';
import { pushOrSlide, type State } from '../state/state.ts';
import type { Store } from '../state/store.ts';
import { scaleOf } from '../state/units.ts';
import type { ToolKind } from '../views/instruments.ts';
import type { Cuts } from './cuts.ts';
import type { Motion, Outcomes } from './outcome.ts';

let nextStroke = 1 + Math.floor(Math.random() * 2 ** 30);

/// Creates a number for commands that share one step of undo.
export const newStroke = (): number => nextStroke++;

export interface Stroke {
    /// Moves the target of the stroke [mm, LPS].
    to(place: Vec3): void;
    /// Ends the stroke. @returns a promise that resolves when the server has done everything
    end(): Promise<void>;
    /// Position of the tool, to be drawn; a line for a cut.
    readonly path: readonly Vec3[];
    readonly radius: number;
    readonly kind: ToolKind;
    readonly closed?: boolean; ///< holds tissue
}

/// Parts of the scene that strokes use.
export interface Means {
    readonly connection: Connection;
    readonly store: Store;
    readonly outcomes: Outcomes;
    readonly cuts: Cuts;
}

/// Follows the newest target, one command after the other.
abstract class Follower implements Stroke {
    protected target: Vec3;
    path: readonly Vec3[];
    private busy: Promise<void> | undefined;

    constructor(
        protected readonly means: Means,
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
        this.means.store.set({ hands: { force_n: 0, energy_per_mm: 0 } });
    }

    /// Length scale of the scan; 1 for a patient.
    protected get scale(): number {
        return scaleOf(this.means.store.state.scan.volume);
    }

    /// Tests whether the tool is outside of the scan, where no tissue is, and says so.
    protected isOutside(place: Vec3): boolean {
        const { store, outcomes } = this.means;
        const { volume } = store.state.scan;
        if (!volume || isWithin(gridOf(volume), place)) return false;
        outcomes.show({ text: 'no tissue here', place, obstacle: null, isStopped: false });
        return true;
    }

    /// Makes one step towards the target. @returns whether to go on
    protected abstract advance(): Promise<boolean>;
    protected async finish(): Promise<void> {}

    protected async ask(command: Command, motion?: Motion): Promise<Done | undefined> {
        const answer = await this.means.connection.ask(command);
        if (motion) this.means.outcomes.take(answer, motion);
        return answer?.t === 'done' ? answer : undefined;
    }

    private async follow(): Promise<void> {
        while (await this.advance());
    }
}

// Lengths for a patient (scaleOf).
const kCellStep = 1; // longest push of a single cell [mm]
const kMinCarving = 0.5; // smallest radius for carving: single cells can't be carved [mm]
const kMinMotion = 0.02; // shorter motions are postponed [mm]
const kCutStep = 0.5; // between points of a cut's line [mm]

/// Radius of the scoop [mm].
export const carvingRadius = ({ tool, scan }: State): number =>
    Math.max(tool.radius, scaleOf(scan.volume) * kMinCarving);

/// Step from a to b of limited length; undefined if it is too short.
function stepTo(a: Vec3, b: Vec3, most: number, least: number): Vec3 | undefined {
    const way = sub(b, a);
    const length = norm(way);
    if (length < least) return undefined;
    return length > most ? mul(most / length, way) : way;
}

/// Stroke of a sphere that drags tissue along, or that tissue slides off.
export class PushStroke extends Follower {
    private place: Vec3;
    private readonly stroke = newStroke();
    private readonly verb: 'push' | 'slide';

    constructor(means: Means, start: Vec3) {
        const { store } = means;
        super(means, start, store.state.tool.radius, 'ball');
        this.place = start;
        const slides = store.state.tool.slide && this.radius > 0;
        this.verb = pushOrSlide(store.state, slides);
    }

    protected async advance(): Promise<boolean> {
        // With radius 0 the tool moves the eight elements of its cell in steps of kCellStep.
        const { scale } = this;
        const most = this.radius || scale * kCellStep;
        const push = stepTo(this.place, this.target, most, scale * kMinMotion);
        if (!push || this.isOutside(this.place)) return false;
        const { place, radius, stroke } = this;
        const done = await this.ask(
            { do: this.verb, point: place, push, radius, stroke },
            { from: place, by: push, radius },
        );
        if (!done) return false;
        const fraction = done.grabbed_elements === 0 ? 1 : (done.step_fraction ?? 1);
        this.place = done.end ?? along(this.place, fraction, push);
        this.path = [this.place];
        if (fraction < 1) this.target = this.place; // an obstacle ends the stroke
        return fraction === 1;
    }

    protected override async finish(): Promise<void> {
        await this.ask({ do: 'release' });
    }
}

/// Stroke of a grasper: grabs tissue and drags it.
export class GrabStroke extends Follower {
    private readonly start: Vec3;
    private offset: Vec3 = [0, 0, 0];
    private held: boolean | undefined;

    get closed(): boolean {
        return this.held === true;
    }

    constructor(means: Means, start: Vec3) {
        super(means, start, means.store.state.tool.radius, 'grasper');
        this.start = start;
    }

    protected async advance(): Promise<boolean> {
        if (this.held === undefined) {
            const { start, radius } = this;
            if (this.isOutside(start)) return false;
            const done = await this.ask(
                { do: 'grab', point: start, radius },
                { from: start, by: [0, 0, 0], radius },
            );
            this.held = (done?.grabbed_elements ?? 0) > 0;
        }
        const offset = sub(this.target, this.start);
        if (!this.held || norm(sub(offset, this.offset)) < this.scale * kMinMotion) return false;
        const done = await this.ask(
            { do: 'drag', offset },
            { from: this.path[0]!, by: sub(offset, this.offset), radius: this.radius },
        );
        if (!done) return false;
        // It stays where the tissue stopped, and tries again when the pointer moves.
        const fraction = done.step_fraction ?? 1;
        this.offset = along(this.offset, fraction, sub(offset, this.offset));
        this.path = [along(this.start, 1, this.offset)];
        return fraction === 1;
    }

    protected override async finish(): Promise<void> {
        if (this.held) await this.ask({ do: 'let_go' });
    }
}

/// Stroke of a scoop: removes tissue along the pointer's path.
export class CarveStroke extends Follower {
    private place: Vec3;
    private begun = false;
    private readonly stroke = newStroke();

    constructor(means: Means, start: Vec3) {
        super(means, start, carvingRadius(means.store.state), 'scoop');
        this.place = start;
    }

    protected async advance(): Promise<boolean> {
        const way = stepTo(this.place, this.target, Infinity, this.scale * kMinMotion);
        if (this.begun && !way) return false;
        this.begun = true;
        const to = way ? along(this.place, 1, way) : this.place;
        const { place: from, radius, stroke } = this;
        const done = await this.ask(
            { do: 'carve', from, to, radius, stroke },
            { from, by: sub(to, from), radius },
        );
        this.place = to;
        this.path = [to];
        return done !== undefined;
    }
}

const kMaxPoints = 500;

/// Stroke of a blade: a line that is cut when the pointer is lifted.
export class CutStroke implements Stroke {
    readonly radius = 0;
    readonly kind = 'blade';
    path: Vec3[];

    /// @param direction  from the line into the tissue, unit
    /// @param centred  the line is in the middle of the cut, else near its front
    constructor(
        private readonly means: Means,
        start: Vec3,
        private readonly direction: Vec3,
        private readonly centred: boolean,
    ) {
        this.path = [start];
    }

    to(place: Vec3): void {
        const last = this.path[this.path.length - 1]!;
        const step = scaleOf(this.means.store.state.scan.volume) * kCutStep;
        if (norm(sub(place, last)) >= step && this.path.length < kMaxPoints) this.path.push(place);
    }

    async end(): Promise<void> {
        if (this.path.length < 2) return;
        const { connection, store, outcomes, cuts } = this.means;
        const depth = mul(store.state.tool.depth, this.direction);
        // In a section the cut extends equally to the front and to the back; at a wall it starts
        // just in front of it.
        const shift = this.centred ? -0.5 : -0.15;
        const line = this.path.map((p) => along(p, shift, depth));
        const motion = { from: this.path[0]!, by: depth, radius: 0 };
        const steps = cuts.nextStep;
        const answer = await connection.ask({ do: 'cut', line, depth });
        outcomes.take(answer, motion);
        if (answer?.t === 'done' && answer.cut_links) cuts.add({ line, depth, steps });
    }
}
