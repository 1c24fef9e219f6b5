// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Two clicks, or the tip and one click, give a way through the lumen: the server looks for it in
// the deformed scan.

import { Path, writePath } from '../maths/path.ts';
import type { Vec3 } from '../maths/vec.ts';
import type { Session } from './session.ts';

const kReach = 5; // so far a click on a wall may be from the lumen [mm]

export class PathTool {
    constructor(
        private readonly session: Session,
        private readonly save: (blob: Blob, name: string) => void,
    ) {}

    /// A click: the first is the way's start, the second its end.
    async click(place: Vec3): Promise<void> {
        const { store } = this.session;
        const { pathFrom, pathBusy } = store.state;
        if (pathBusy) this.session.say('the last way is still being looked for');
        else if (!pathFrom) this.begin(place);
        else await this.find(pathFrom, place);
    }

    /// The way begins at the endoscope's tip.
    fromTip(): void {
        this.begin(this.session.store.state.camera.eye);
        this.session.store.set({ tool: 'path' });
    }

    cancel(): void {
        this.session.store.set({ pathFrom: null });
    }

    private begin(place: Vec3): void {
        this.session.store.set({ pathFrom: place });
        this.session.say('the way begins here; click where it ends');
    }

    private async find(from: Vec3, to: Vec3): Promise<void> {
        const { session } = this;
        const { store } = session;
        if (!store.state.features.includes('path')) {
            session.say('this server looks for no ways; load one with Path…');
            store.set({ pathFrom: null });
            return;
        }
        store.set({ pathBusy: true });
        const asked = store.state.volume?.id;
        const answer = await session.connection.ask({ do: 'path', from, to, reach: kReach });
        store.set({ pathBusy: false, pathFrom: null });
        if (answer?.t !== 'path') return; // session.refused has said why
        if (answer.volume !== asked || answer.volume !== store.state.volume?.id) return;
        if (answer.points.length < 2) {
            session.say('the way begins where it ends; click two different places');
            return;
        }
        store.set({ path: new Path(answer.points, answer.radii), pathWay: 0, pathFlying: false });
        const narrow = Math.min(...answer.radii).toFixed(1);
        const length = Math.round(answer.length_mm);
        session.say(`a way of ${length} mm, ${narrow} mm from the wall at least`);
    }

    saveFile(): void {
        const { path } = this.session.store.state;
        if (!path) return;
        this.save(new Blob([writePath(path)], { type: 'application/json' }), 'way.mrk.json');
    }
}
