// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Paths through the lumen: the server finds one in the deformed scan between two clicks, or between
// the tip and a click. The endoscope flies along it.

import { Path, writePath } from '../maths/path.ts';
import { norm, sub, type Vec3 } from '../maths/vec.ts';
import type { Way } from '../state/state.ts';
import { lengthText, scaleOf } from '../state/units.ts';
import { saveBlob } from './download.ts';
import type { Scene } from './scene.ts';

// Lengths for a patient (scaleOf).
const kReach = 5; // largest distance of a click on a wall to the lumen [mm]
const kLeastWay = 0.01; // between the clicks [mm]
const kSpeed = 20; // along the path [mm/s]

export class PathTool {
    constructor(private readonly scene: Scene) {}

    private get way(): Way {
        return this.scene.store.state.way;
    }
    /// Length scale of the scan; 1 for a patient.
    private get scale(): number {
        return scaleOf(this.scene.store.state.scan.volume);
    }
    private set(way: Partial<Way>): void {
        this.scene.store.set({ way });
    }

    // --- finding one

    /// Takes a click: the first is the start of the path, the second its end.
    async click(place: Vec3): Promise<void> {
        const { from, busy } = this.way;
        if (busy) this.scene.warn('the last path is still being computed');
        else if (!from) this.begin(place);
        else if (norm(sub(place, from)) < kLeastWay * this.scale)
            this.scene.say('the path begins here; click its end');
        else await this.find(from, place);
    }

    /// Begins a path at the endoscope's tip.
    fromTip(): void {
        const { store } = this.scene;
        this.begin(store.state.view.camera.eye);
        store.set({ tool: { name: 'path' } });
    }

    cancel(): void {
        this.set({ from: null });
    }

    private begin(place: Vec3): void {
        this.set({ from: place });
        this.scene.say('the path begins here; click its end');
    }

    private async find(from: Vec3, to: Vec3): Promise<void> {
        const { scene } = this;
        const { store } = scene;
        if (!store.state.link.features.includes('path')) {
            scene.warn('this server computes no paths; load one with Path…');
            this.set({ from: null });
            return;
        }
        this.set({ busy: true });
        const asked = store.state.scan.volume?.id;
        const answer = await scene.connection.ask({
            do: 'path',
            from,
            to,
            reach: this.scale * kReach,
        });
        this.set({ busy: false, from: null });
        if (answer?.t !== 'path') return; // Session.refused has shown the reason
        if (answer.volume !== asked || answer.volume !== store.state.scan.volume?.id) return;
        if (answer.points.length < 2) {
            scene.warn('the path begins where it ends; click two different points');
            return;
        }
        this.set({ path: new Path(answer.points, answer.radii), position: 0, flying: false });
        const { volume } = store.state.scan;
        const narrow = lengthText(volume, Math.min(...answer.radii));
        const length = lengthText(volume, answer.length_mm, 1);
        scene.say(`a path of ${length} mm, at least ${narrow} mm from the wall`);
    }

    // --- flying along it

    /// Shows another path, and goes to its start.
    use(path: Path): void {
        this.set({ path, flying: false });
        this.goTo(0);
    }

    /// Goes to a position on the path [mm].
    goTo(position: number): void {
        const { path } = this.way;
        if (!path) return;
        const kept = Math.min(Math.max(position, 0), path.length);
        const camera = path.camera(kept, this.scene.store.state.view.camera.up, this.scale);
        this.scene.store.set({
            view: { camera },
            sections: { cursor: camera.eye },
            way: { position: kept },
        });
    }

    /// Flies on from the nearest point of the path, or pauses.
    toggle(): void {
        const { path, flying, position } = this.way;
        const { history, store } = this.scene;
        if (!path) return;
        if (flying) history.end('path');
        else {
            history.begin();
            const nearest = path.nearest(store.state.view.camera.eye);
            const atEnd = Math.max(nearest, position) > path.length - 0.5 * this.scale;
            this.set({ position: atEnd ? 0 : nearest });
        }
        this.set({ flying: !flying });
    }

    pause(): void {
        if (this.way.flying) this.toggle();
    }

    /// Flies on for a frame's time.
    follow(seconds: number): void {
        const { path, flying, position } = this.way;
        if (!path || !flying) return;
        const speed = this.scale * kSpeed * this.scene.store.state.flight.speed;
        this.goTo(position + speed * seconds);
        if (this.way.position >= path.length) this.toggle();
    }

    saveFile(): void {
        const { path } = this.way;
        if (!path) return;
        saveBlob(new Blob([writePath(path)], { type: 'application/json' }), 'way.mrk.json');
    }
}
