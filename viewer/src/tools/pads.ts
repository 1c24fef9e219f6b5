// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Game pads, and SpaceMouse by WebHID, as devices of the browser: both give speeds, right, up and
// towards the user, in the axes of haptic devices.

import type { Vec3 } from '../maths/vec.ts';

/// Speed to the right, up, towards the user [mm/s].
export type Motion = Vec3;
export const kNoMotion: Motion = [0, 0, 0];

const kFastest = 40; // [mm/s]
const kDeadZone = 0.12; // sticks don't return to exactly 0
const kFarthest = 100; // from the middle of the workspace [mm]
const kFullCap = 350; // full deflection in a SpaceMouse's reports

const curved = (x: number): number => {
    const over = Math.max(Math.abs(x) - kDeadZone, 0) / (1 - kDeadZone);
    return Math.sign(x) * Math.min(over, 1) ** 2;
};

export interface Pad {
    readonly axes: readonly number[];
    readonly buttons: readonly { readonly pressed: boolean }[];
}

export const buttonsOff = (pad: Pad): boolean => !pad.buttons.some((b) => b.pressed);

/// Motion by a game pad: the left stick moves aside and up, the right one ahead (up) and back.
export function padMotion({ axes }: Pad): Motion {
    const [x = 0, y = 0, , ahead = 0] = axes;
    return [kFastest * curved(x), -kFastest * curved(y), kFastest * curved(ahead)];
}

/// Motion by a report of the SpaceMouse: three 16-bit integers, right, towards the user, down.
export function capMotion(report: DataView): Motion {
    const at = (n: number): number => report.getInt16(2 * n, true) / kFullCap;
    return [kFastest * curved(at(0)), -kFastest * curved(at(2)), kFastest * curved(at(1))];
}

/// Position after a time, clamped to the workspace.
export function moved(place: Vec3, motion: Motion, seconds: number): Vec3 {
    return place.map((x, a) =>
        Math.min(Math.max(x + motion[a]! * seconds, -kFarthest), kFarthest),
    ) as unknown as Vec3;
}

interface Hid {
    requestDevice(options: { filters: { vendorId: number }[] }): Promise<HidDevice[]>;
}
interface HidDevice {
    open(): Promise<void>;
    addEventListener(
        type: 'inputreport',
        listener: (event: { reportId: number; data: DataView }) => void,
    ): void;
}

/// Lets the user choose a SpaceMouse. @returns its motion; undefined if none was chosen
export async function spaceMouse(): Promise<(() => Motion) | undefined> {
    const { hid } = navigator as unknown as { hid?: Hid };
    if (!hid) throw new Error('this browser has no WebHID; expected Chromium, or use a game pad');
    const filters = [{ vendorId: 0x256f }, { vendorId: 0x046d }]; // 3Dconnexion, Logitech
    const [device] = await hid.requestDevice({ filters });
    if (!device) return undefined;
    await device.open();
    let motion = kNoMotion;
    device.addEventListener('inputreport', ({ reportId, data }) => {
        if (reportId === 1 && data.byteLength >= 6) motion = capMotion(data);
    });
    return () => motion;
}
