// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Steering of the endoscope by keys that are held.

import type { Vec3 } from '../maths/vec.ts';
import type { State } from '../state/state.ts';
import { keysDrive } from './catheter_hand.ts';

/// Motion along right, up and ahead, and turns; each −1…1.
export interface Steering {
    readonly move: Vec3;
    readonly yaw: number;
    readonly pitch: number;
    readonly roll: number;
}

type Axis = 'x' | 'y' | 'z' | 'yaw' | 'pitch' | 'roll';

/// Keys that fly and turn, each with its share of the motion.
const kFlight: Readonly<Record<string, Partial<Record<Axis, number>>>> = {
    KeyW: { z: 1 },
    KeyS: { z: -1 },
    KeyA: { x: -1 },
    KeyD: { x: 1 },
    KeyR: { y: 1 },
    KeyF: { y: -1 },
    KeyQ: { roll: 1 },
    KeyE: { roll: -1 },
    ArrowLeft: { yaw: -1 },
    ArrowRight: { yaw: 1 },
    ArrowUp: { pitch: 1 },
    ArrowDown: { pitch: -1 },
};

export const isFlightKey = (code: string): boolean => code in kFlight;

export const inEndoscope = ({ pointer }: State): boolean => pointer.active === 'endoscope';

/// On-screen stick, −1…1.
export interface Stick {
    ahead: number;
    right: number;
}

/// Sum of the held keys and the stick; zero unless the endoscope's view is active and from inside.
export function steeringOf(held: ReadonlySet<string>, stick: Stick, state: State): Steering {
    const sum: Record<Axis, number> = { x: 0, y: 0, z: 0, yaw: 0, pitch: 0, roll: 0 };
    if (inEndoscope(state) && !state.view.outside) {
        if (!keysDrive(state)) {
            sum.z += stick.ahead;
            sum.yaw += stick.right;
        }
        for (const code of held) {
            if (code.startsWith('Arrow') && keysDrive(state)) continue; // the catheter's
            for (const [axis, by] of Object.entries(kFlight[code] ?? {})) sum[axis as Axis] += by;
        }
    }
    const { x, y, z, yaw, pitch, roll } = sum;
    return { move: [x, y, z], yaw, pitch, roll };
}
