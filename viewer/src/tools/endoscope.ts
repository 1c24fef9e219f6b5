// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Free flight of the endoscope: its tip stops at walls, pushes them, or passes through. The eye
// gives way to tissue that is moved over it.

import { clearance, flown, freePlace, speedFor, wouldTouch } from '../maths/flight.ts';
import { frameOf, naturalUp } from '../maths/rays.ts';
import { add, along, mul, norm, normalized, sub, turned, type Vec3 } from '../maths/vec.ts';
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

export class Endoscope {
    private pushing = false; // a push of the tip has no answer yet
    private tipStroke = 0;
    private flying = false;
    private eyeIsFree = false; // the eye was in the lumen, and has to stay there
    private displaced: { from: Vec3; to: Vec3 } | undefined; // by tissue over the eye

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
    }

    /// Forgets the stroke of the tip, for another scan.
    forget(): void {
        this.tipStroke = 0;
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
        const reach = this.scale * kEscape;
        const to = freePlace(scene.volume, this.eye, flight.tip, scene.surface, reach);
        if (!to) {
            scene.warn('tissue has closed around the endoscope');
            return;
        }
        const from = this.displaced?.from ?? this.eye;
        this.moveEye(to);
        this.displaced = { from, to };
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
