// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Drive of the catheter: the sum of keys (while the tool Catheter is chosen), game pads and the
// panel's sliders. Changes are sent to the server, the end of a motion at once. An idle hand sends
// nothing, so that another client may drive.

import type { Command } from '../net/protocol.ts';
import { hasVessel, type State } from '../state/state.ts';
import type { Haptics } from './haptics.ts';
import type { Scene } from './scene.ts';

/// Wished motion, as shares of full speed, −1…1.
export interface Wish {
    insert: number;
    rotate: number;
    bend: readonly [number, number];
}

/// State of a game pad. The left stick inserts and rotates, the right one bends. Browsers report a
/// SpaceMouse as a game pad: its cap is shifted ahead, twisted, and tilted.
export interface Pad {
    readonly id?: string;
    readonly axes: readonly number[];
    readonly buttons: readonly { readonly pressed: boolean }[];
}

export const kMaxInsert = 100; // [mm/s]
export const kMaxBend = 180; // [degrees]
const kRotateRate = 180; // of keys and sticks [degrees/s]
const kBendRate = 60; // [degrees/s]
const kDeadZone = 0.15; // of sticks that don't return to exactly 0
const kSendMs = 50;
const kSpaceMouse = /3dconnexion|space ?(mouse|navigator|pilot)/i;

export const drives = (state: State): boolean => state.link.role === 'control' && hasVessel(state);

/// Tests whether arrow keys drive the catheter.
export const keysDrive = (state: State): boolean => state.tool.name === 'catheter' && drives(state);

const clamp = (x: number, most: number): number => Math.min(Math.max(x, -most), most);

export function wishOfKeys(held: ReadonlySet<string>): Wish {
    const shift = held.has('ShiftLeft') || held.has('ShiftRight');
    const axis = (more: string, less: string): number =>
        Number(held.has(more)) - Number(held.has(less));
    const up = axis('ArrowUp', 'ArrowDown');
    const right = axis('ArrowRight', 'ArrowLeft');
    return shift
        ? { insert: 0, rotate: 0, bend: [up, right] }
        : { insert: up, rotate: right, bend: [0, 0] };
}

export function wishOfPad(pad: Pad): Wish {
    const axis = (n: number): number => {
        const x = pad.axes[n] ?? 0;
        const beyond = (Math.abs(x) - kDeadZone) / (1 - kDeadZone);
        return beyond > 0 ? Math.sign(x) * Math.min(beyond, 1) : 0;
    };
    // Sticks that are pushed ahead report −1.
    if (kSpaceMouse.test(pad.id ?? ''))
        return { insert: 0 - axis(1), rotate: axis(5), bend: [0 - axis(3), axis(4)] };
    return { insert: 0 - axis(1), rotate: axis(0), bend: [0 - axis(3), axis(2)] };
}

export const sumOf = (a: Wish, b: Wish): Wish => ({
    insert: clamp(a.insert + b.insert, 1),
    rotate: clamp(a.rotate + b.rotate, 1),
    bend: [clamp(a.bend[0] + b.bend[0], 1), clamp(a.bend[1] + b.bend[1], 1)],
});

const kNothing: Wish = { insert: 0, rotate: 0, bend: [0, 0] };

export class CatheterHand {
    /// Speeds of the panel's sliders while they are held [mm/s], [degrees/s].
    insert = 0;
    rotate = 0;
    /// Requested bends that the state doesn't have yet [degrees].
    bendWish: readonly [number, number] | undefined;
    speed = 20; ///< of keys and sticks [mm/s]
    private sentInsert = 0;
    private sentRotate = 0;
    private sentBend = '';
    private lastSent = -Infinity;

    constructor(
        private readonly scene: Scene,
        private readonly held: ReadonlySet<string>,
        private readonly stick: { readonly ahead: number; readonly right: number },
        private readonly device: Haptics,
    ) {}

    /// Bends as requested, else as in the state [degrees].
    get bend(): readonly [number, number] {
        const vessel = this.scene.store.state.shared?.vessel;
        return this.bendWish ?? [vessel?.bend_first_deg ?? 0, vessel?.bend_second_deg ?? 0];
    }

    setBend(which: 0 | 1, degrees: number): void {
        const [first, second] = this.bend;
        const to = clamp(degrees, kMaxBend);
        this.bendWish = which === 0 ? [to, second] : [first, to];
    }

    /// Stops insertion and rotation; the tip stays bent.
    stop(): void {
        this.insert = this.rotate = 0;
        this.tell({ do: 'catheter', insert_mm_s: 0, rotate_deg_s: 0 });
        this.sentInsert = this.sentRotate = 0;
    }

    straighten(): void {
        this.bendWish = [0, 0];
    }

    /// Updates the drive, once per frame.
    tick(seconds: number, now: number): void {
        const { state } = this.scene.store;
        if (!drives(state) || state.link.status !== 'open') {
            this.insert = this.rotate = this.sentInsert = this.sentRotate = 0;
            this.bendWish = undefined;
            return;
        }
        const { vessel } = state.shared!;
        const isBent = (wish: readonly [number, number]): boolean =>
            vessel?.bend_first_deg === wish[0] && vessel.bend_second_deg === wish[1];
        if (this.bendWish && isBent(this.bendWish)) {
            this.bendWish = undefined;
            this.sentBend = '';
        }
        const { ahead: insert, right: rotate } = this.stick;
        let wish = keysDrive(state)
            ? sumOf(wishOfKeys(this.held), { ...kNothing, insert, rotate })
            : kNothing;
        const pads: readonly (Pad | null)[] = this.device.isLed ? [] : navigator.getGamepads();
        for (const pad of pads) if (pad) wish = sumOf(wish, wishOfPad(pad));
        if (wish.bend[0] || wish.bend[1]) {
            const [first, second] = this.bend;
            const by = kBendRate * seconds;
            this.setBend(0, first + by * wish.bend[0]);
            this.setBend(1, second + by * wish.bend[1]);
        }
        this.send(
            clamp(this.insert + this.speed * wish.insert, kMaxInsert),
            this.rotate + kRotateRate * wish.rotate,
            now,
        );
    }

    private send(insert: number, rotate: number, now: number): void {
        const command: Command = { do: 'catheter' };
        if (insert !== this.sentInsert) command.insert_mm_s = insert;
        if (rotate !== this.sentRotate) command.rotate_deg_s = rotate;
        const bend = this.bendWish?.join(' ') ?? this.sentBend;
        if (this.bendWish && bend !== this.sentBend)
            [command.bend_first_deg, command.bend_second_deg] = this.bendWish;
        if (Object.keys(command).length === 1) return;
        const ends =
            (insert === 0 && this.sentInsert !== 0) || (rotate === 0 && this.sentRotate !== 0);
        if (!ends && now - this.lastSent < kSendMs) return;
        this.lastSent = now;
        this.sentInsert = insert;
        this.sentRotate = rotate;
        this.sentBend = bend;
        this.tell(command);
    }

    private tell(command: Command): void {
        void this.scene.ask(command);
    }
}
