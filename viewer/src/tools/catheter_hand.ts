// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The hand on the catheter: keys while the catheter tool is chosen, a game pad, and the panel's
// sliders add up to what it does. The server is told when that changes, and at once when it ends; a
// hand that does nothing says nothing, so that another client may drive.

import type { Command } from '../net/protocol.ts';
import { hasVessel, type State } from '../state/state.ts';
import type { Haptics } from './haptics.ts';
import type { Scene } from './scene.ts';

/// Shares of full speed, −1…1, ahead or to one side.
export interface Wish {
    insert: number;
    rotate: number;
    bend: readonly [number, number];
}

/// What of a game pad is looked at. The left stick inserts and rotates, the right one bends. A
/// SpaceMouse, which browsers take for one: its cap is shifted ahead, twisted, and tilted.
export interface Pad {
    readonly id?: string;
    readonly axes: readonly number[];
    readonly buttons: readonly { readonly pressed: boolean }[];
}

export const kMostInsert = 100; // [mm/s]
export const kMostBend = 180; // [degrees]
const kRotateRate = 180; // of keys and sticks [degrees/s]
const kBendRate = 60; // [degrees/s]
const kDeadZone = 0.15; // of sticks that don't quite come back
const kSendMs = 50;
const kSpaceMouse = /3dconnexion|space ?(mouse|navigator|pilot)/i;

export const drives = (state: State): boolean => state.link.role === 'control' && hasVessel(state);

/// Whether arrow keys are the catheter's.
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
    // Sticks that are pushed ahead say −1.
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
    /// Of the panel's sliders, while they are held [mm/s], [degrees/s].
    insert = 0;
    rotate = 0;
    /// That was asked for and isn't in the state yet [degrees].
    bendWish: readonly [number, number] | undefined;
    speed = 20; ///< of keys and sticks [mm/s]
    private sentInsert = 0;
    private sentRotate = 0;
    private sentBend = '';
    private lastSent = -Infinity;

    constructor(
        private readonly scene: Scene,
        private readonly held: ReadonlySet<string>,
        private readonly device: Haptics,
    ) {}

    /// As asked for, or as it is [degrees].
    get bend(): readonly [number, number] {
        const vessel = this.scene.store.state.shared?.vessel;
        return this.bendWish ?? [vessel?.bend_first_deg ?? 0, vessel?.bend_second_deg ?? 0];
    }

    setBend(which: 0 | 1, degrees: number): void {
        const [first, second] = this.bend;
        const to = clamp(degrees, kMostBend);
        this.bendWish = which === 0 ? [to, second] : [first, to];
    }

    /// Nothing moves any more; the tip stays bent.
    stop(): void {
        this.insert = this.rotate = 0;
        this.tell({ do: 'catheter', insert_mm_s: 0, rotate_deg_s: 0 });
        this.sentInsert = this.sentRotate = 0;
    }

    straighten(): void {
        this.bendWish = [0, 0];
    }

    /// Each frame.
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
        let wish = keysDrive(state) ? wishOfKeys(this.held) : kNothing;
        const pads: readonly (Pad | null)[] = this.device.isLed ? [] : navigator.getGamepads();
        for (const pad of pads) if (pad) wish = sumOf(wish, wishOfPad(pad));
        if (wish.bend[0] || wish.bend[1]) {
            const [first, second] = this.bend;
            const by = kBendRate * seconds;
            this.setBend(0, first + by * wish.bend[0]);
            this.setBend(1, second + by * wish.bend[1]);
        }
        const insert = clamp(this.insert + this.speed * wish.insert, kMostInsert);
        const rotate = this.rotate + kRotateRate * wish.rotate;
        this.send(insert, rotate, now);
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
