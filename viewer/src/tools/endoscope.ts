// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Free flight of the endoscope: its tip stops at walls, pushes them, or passes through. The eye
// gives way to tissue that is moved over it.

import { clearance, flown, freePlace, meetsWall, speedFor, wouldTouch } from '../maths/flight.ts';
import { frameOf, naturalUp } from '../maths/rays.ts';
import { add, along, mul, norm, normalized, sub, turned, type Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';
import type { Command } from '../net/protocol.ts';
import { pushOrSlide } from '../state/state.ts';
import { scaleOf } from '../state/units.ts';
import type { Scene } from './scene.ts';
import type { Steering } from './steering.ts';
import { newStroke } from './strokes.ts';

// Lengths in a body.
const kRoomReach = 60; // the speed ignores walls farther away [mm]
const kEscape = 40; // search radius for a free position, of an eye in tissue [mm]
const kTurnRate = 70; // of the keyboard [degrees/s]
const kTrackStep = 1; // between two positions of the track
const kTrackLength = 200; // positions

export class Endoscope {
    private pushing = false; // a push of the tip has no answer yet
    private tipStroke = 0;
    private flying = false;
    private eyeIsFree = false; // the eye was in the lumen, and has to stay there
    private displaced: { from: Vec3; to: Vec3 } | undefined; // by tissue over the eye
    private track: Vec3[] = []; // of the eye in its lumen, the newest last

    constructor(private readonly scene: Scene) {
        scene.store.listen((state, before) => {
            const { camera } = state.view;
            if (camera !== before.view.camera || state.flight.wall !== before.flight.wall)
                this.judgeEye();
        });
    }

    /// Updates whether the eye is free, after a change of the threshold: it doesn't move the eye,
    /// which may lie in tissue from then on.
    judgeEye(): void {
        this.eyeIsFree = !this.scene.isInTissue(this.eye);
        if (this.eyeIsFree) this.remember(this.eye);
    }

    /// Radius of the tip, which holds the tissue at rest that it has pressed aside; 0: it gives way
    /// itself. An eye that tissue carried aside holds nothing, else each would prop the other.
    get holdingRadius(): number {
        const { wall, tip } = this.scene.store.state.flight;
        return wall === 'pass' || this.displaced ? 0 : tip;
    }

    /// Forgets the stroke of the tip and its track, for another scan.
    forget(): void {
        this.tipStroke = 0;
        this.track = [];
        this.displaced = undefined;
    }

    /// Begins or ends a flight by the keyboard. @returns whether the keys move the endoscope
    takeUp({ move, yaw, pitch, roll }: Steering): boolean {
        const { history } = this.scene;
        const moves = norm(move) > 0 || yaw !== 0 || pitch !== 0 || roll !== 0;
        if (moves && !this.flying) history.begin();
        if (!moves && this.flying) history.end('flight');
        this.flying = moves;
        return moves;
    }

    /// Turns and flies by the keys, at a speed that follows the clearance around the tip.
    steer({ move, yaw, pitch, roll }: Steering, seconds: number): void {
        const angle = (kTurnRate * Math.PI * seconds) / 180;
        this.turn(yaw * angle, pitch * angle, roll * angle);
        if (!(norm(move) > 0)) return;
        const { view, flight } = this.scene.store.state;
        const { scale } = this;
        const { surface, volume } = this.scene;
        const room = clearance(volume!, view.camera.eye, surface, scale * kRoomReach);
        const way = Math.min(norm(move), 1) * flight.speed * speedFor(room, scale) * seconds;
        const { right, up, forward } = frameOf(view.camera);
        const [x, y, z] = normalized(move);
        this.fly(mul(way, add(add(mul(x, right), mul(y, up)), mul(z, forward))));
    }

    /// Turns about the endoscope's own axes [radians].
    turn(yaw: number, pitch: number, roll = 0): void {
        if (!yaw && !pitch && !roll) return;
        const { camera } = this.scene.store.state.view;
        const { right, up, forward } = frameOf(camera);
        let look = turned(turned(forward, up, -yaw), turned(right, up, -yaw), pitch);
        look = normalized(look);
        const tilted = turned(turned(up, turned(right, up, -yaw), pitch), look, roll);
        this.scene.store.set({ view: { camera: { ...camera, look, up: tilted } } });
    }

    /// Moves the tip as far as the wall allows. The crosshair stays with the tip.
    fly(motion: Vec3): void {
        const { volume, store, surface } = this.scene;
        if (!volume) return;
        const { wall, tip } = store.state.flight;
        const from = this.eye;
        if (wall === 'pass') this.moveEye(add(from, motion));
        else if (wall === 'stop' || store.state.link.role === 'view')
            this.moveEye(flown(volume, from, motion, tip, surface));
        else this.pushOn(from, motion);
    }

    /// Moves the endoscope to a position, inside or outside of tissue.
    goTo(eye: Vec3, look: Vec3, up: Vec3 = naturalUp(look)): void {
        const { history, store } = this.scene;
        history.step('go to', () =>
            store.set({
                view: { camera: { eye, look: normalized(look), up } },
                sections: { cursor: eye },
            }),
        );
    }

    /// Keeps the eye out of tissue: moves it out of tissue that was deformed over it, and back when
    /// the tissue has gone.
    keepEyeFree(): void {
        const { scene } = this;
        const { flight, scan } = scene.store.state;
        if (!scene.volume || flight.wall === 'pass' || scan.loaded < 1) return;
        const back = this.displaced;
        if (back && norm(sub(back.to, this.eye)) > 0)
            this.displaced = undefined; // it was moved
        else if (back && !scene.isInTissue(back.from)) {
            this.displaced = undefined;
            this.moveEye(back.from);
            return;
        }
        if (!this.eyeIsFree || !scene.isInTissue(this.eye)) return;
        const to = this.wayOut(scene.volume, flight.tip);
        if (!to) {
            scene.warn('tissue has closed around the endoscope');
            return;
        }
        const from = this.displaced?.from ?? this.eye;
        this.moveEye(to);
        this.displaced = { from, to };
    }

    /// Free position near the eye on its side of the wall: on the way from the newest free position
    /// of its track. Without one, the nearest on any side.
    private wayOut(volume: VolumeData, tip: number): Vec3 | undefined {
        const { surface } = this.scene;
        for (let n = this.track.length - 1; n >= 0; --n) {
            const start = this.track[n]!;
            if (!this.scene.isInTissue(start))
                return flown(volume, start, sub(this.eye, start), tip, surface);
        }
        return freePlace(volume, this.eye, tip, surface, this.scale * kEscape);
    }

    /// Adds a free position to the track, which begins anew behind a wall.
    private remember(eye: Vec3): void {
        const { volume, surface } = this.scene;
        const last = this.track[this.track.length - 1];
        if (last && norm(sub(eye, last)) < this.scale * kTrackStep) return;
        if (last && volume && meetsWall(volume, last, eye, surface)) this.track = [];
        this.track.push(eye);
        if (this.track.length > kTrackLength) this.track.shift();
    }

    private pushOn(from: Vec3, motion: Vec3): void {
        if (this.pushing) return;
        const { store, connection, volume, surface, outcomes } = this.scene;
        const { tip } = store.state.flight;
        const to = add(from, motion);
        if (!wouldTouch(volume!, from, to, tip, surface)) {
            this.moveEye(to);
            this.tipStroke = 0;
            return;
        }
        this.tipStroke ||= newStroke();
        this.pushing = true;
        const stroke = this.tipStroke;
        const verb = pushOrSlide(store.state, true);
        const command: Command = { do: verb, point: from, push: motion, radius: tip, stroke };
        void connection.ask(command).then((answer) => {
            this.pushing = false;
            outcomes.take(answer, { from, by: motion, radius: tip });
            if (answer?.t !== 'done') return;
            // The eye may have been turned meanwhile, but not moved.
            this.moveEye(answer.end ?? along(from, answer.step_fraction ?? 1, motion));
            this.eyeIsFree = true; // once the voxels are here
        });
    }

    /// Length scale of the scan; 1 for a patient.
    private get scale(): number {
        return scaleOf(this.scene.store.state.scan.volume);
    }

    private get eye(): Vec3 {
        return this.scene.store.state.view.camera.eye;
    }

    private moveEye(eye: Vec3): void {
        const { camera } = this.scene.store.state.view;
        this.scene.store.set({ view: { camera: { ...camera, eye } }, sections: { cursor: eye } });
    }
}
