// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The scan on the page with its mirrors, and the objects that all tools need: state, undo, stage,
// and connection.

import { voxelFromWorld } from '../maths/grid.ts';
import { inTissue, type Surface } from '../maths/rays.ts';
import type { Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';
import type { Connection } from '../net/connection.ts';
import type { Command, Done } from '../net/protocol.ts';
import type { Vessel } from '../net/vessel.ts';
import { nameOfClient } from '../state/company.ts';
import { History } from '../state/history.ts';
import { surfaceOf } from '../state/state.ts';
import type { Store } from '../state/store.ts';
import type { Stage } from '../views/stage.ts';
import { Cuts } from './cuts.ts';
import { type Motion, Outcomes } from './outcome.ts';

const kNewsMs = 2000; // longest wait for the state after an undo

export interface SceneParts {
    readonly store: Store;
    readonly stage: Stage;
    readonly connection: Connection;
    /// Shows a line for some seconds, and gives it to screen readers.
    say(text: string, isWarning: boolean): void;
}

export class Scene {
    readonly store: Store;
    readonly stage: Stage;
    readonly connection: Connection;
    readonly history: History;
    readonly outcomes: Outcomes;
    readonly cuts: Cuts;
    volume: VolumeData | undefined;
    vessel: Vessel | undefined;
    private stepsArrived: () => void = () => {};

    constructor(private readonly parts: SceneParts) {
        this.store = parts.store;
        this.stage = parts.stage;
        this.connection = parts.connection;
        this.outcomes = new Outcomes(parts.store);
        this.cuts = new Cuts(parts.store);
        this.history = new History(parts.store, (step) => this.step(step));
    }

    /// Shows a line for some seconds, and gives it to screen readers.
    say(text: string): void {
        this.parts.say(text, false);
    }

    /// Shows a line about something that did not work.
    warn(text: string): void {
        this.parts.say(text, true);
    }

    /// Sends a command, and shows its outcome. @returns whether it was done
    async ask(command: Command, motion?: Motion): Promise<boolean> {
        const answer = await this.connection.ask(command);
        this.outcomes.take(answer, motion);
        return answer?.t === 'done';
    }

    get surface(): Surface {
        return surfaceOf(this.store.state);
    }

    isInTissue(place: Vec3): boolean {
        const { volume } = this;
        if (!volume) return false;
        return inTissue(volume.sample(voxelFromWorld(volume.grid, place)), this.surface);
    }

    /// Ends the wait of an undo or redo, when a state message with the remaining steps has arrived.
    protected tellSteps(): void {
        this.stepsArrived();
    }

    /// Undoes or redoes, and waits for the remaining steps.
    private async step(step: 'undo' | 'redo'): Promise<void> {
        const news = new Promise<void>((resolve) => {
            this.stepsArrived = resolve;
            setTimeout(resolve, kNewsMs);
        });
        const answer = await this.connection.ask({ do: step });
        this.outcomes.show(null);
        if (answer?.t !== 'done') return;
        this.say(`${step === 'undo' ? 'undone' : 'done again'}${this.stepText(answer)}`);
        await news;
    }

    /// Name of a step, with the people who made it if others have a part in it.
    private stepText({ message, whose = [] }: Done): string {
        if (!message) return '';
        const own = this.connection.client;
        if (whose.every((client) => client === own)) return `: ${message}`;
        const { shared } = this.store.state;
        const people = whose.map((client) =>
            client === own ? 'you' : nameOfClient(shared, client),
        );
        return `: ${message} by ${people.join(' and ')}`;
    }
}
