// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Movies as keyframes. The eye follows a Catmull-Rom curve through them, the camera turns by slerp;
// field of view, threshold and window are interpolated linearly. apps/pliant/keyframes.cpp has the
// same formulas, so that `pliant render --keyframes` makes the same movie.

import { type Camera, frameOf } from './rays.ts';
import { add, mul, norm, sub, type Vec3 } from './vec.ts';

export interface Shot {
    readonly camera: Camera;
    readonly fieldOfView: number; ///< [degrees]
    readonly iso: number; ///< [HU]
    readonly window: number;
    readonly level: number;
}

export interface Keyframe extends Shot {
    readonly seconds: number; ///< since the previous keyframe; 0 for the first
}

type Quaternion = readonly [number, number, number, number]; // x, y, z, w

/// Time of each keyframe [s].
export function timesOf(frames: readonly Keyframe[]): number[] {
    let time = 0;
    return frames.map((frame, i) => (time += i > 0 ? frame.seconds : 0));
}

export const lengthOf = (frames: readonly Keyframe[]): number =>
    frames.length ? timesOf(frames)[frames.length - 1]! : 0;

/// Interpolates the movie at a time [s]. @pre at least one keyframe
export function shotAt(frames: readonly Keyframe[], time: number): Shot {
    const times = timesOf(frames);
    const last = frames.length - 1;
    if (!(time > 0) || last === 0) return frames[0]!;
    if (time >= times[last]!) return frames[last]!;
    const i = times.findIndex((t) => t > time) - 1;
    const [a, b] = [frames[i]!, frames[i + 1]!];
    const span = times[i + 1]! - times[i]!;
    const s = (time - times[i]!) / span;
    const even = (x: number, y: number): number => x + s * (y - x);
    const slope = (k: number): Vec3 => {
        const [before, after] = [Math.max(k - 1, 0), Math.min(k + 1, last)];
        const way = sub(frames[after]!.camera.eye, frames[before]!.camera.eye);
        return mul(span / (times[after]! - times[before]!), way);
    };
    const s2 = s * s;
    const s3 = s2 * s;
    const eye = add(
        add(mul(2 * s3 - 3 * s2 + 1, a.camera.eye), mul(s3 - 2 * s2 + s, slope(i))),
        add(mul(3 * s2 - 2 * s3, b.camera.eye), mul(s3 - s2, slope(i + 1))),
    );
    const turn = slerp(quaternionOf(a.camera), quaternionOf(b.camera), s);
    return {
        camera: { eye, ...directionsOf(turn) },
        fieldOfView: even(a.fieldOfView, b.fieldOfView),
        iso: even(a.iso, b.iso),
        window: even(a.window, b.window),
        level: even(a.level, b.level),
    };
}

/// Rotation with columns right, up and backward.
function quaternionOf(camera: Camera): Quaternion {
    const { right, up, forward } = frameOf(camera);
    const m = [right, up, mul(-1, forward)];
    const at = (row: number, column: number): number => m[column]![row]!;
    const trace = at(0, 0) + at(1, 1) + at(2, 2);
    if (trace > 0) {
        const r = 2 * Math.sqrt(1 + trace);
        const [x, y, z] = [at(2, 1) - at(1, 2), at(0, 2) - at(2, 0), at(1, 0) - at(0, 1)];
        return [x / r, y / r, z / r, r / 4];
    }
    const i = at(0, 0) > at(1, 1) && at(0, 0) > at(2, 2) ? 0 : at(1, 1) > at(2, 2) ? 1 : 2;
    const [j, k] = [(i + 1) % 3, (i + 2) % 3];
    const r = 2 * Math.sqrt(1 + at(i, i) - at(j, j) - at(k, k));
    const q = [0, 0, 0, (at(k, j) - at(j, k)) / r];
    q[i] = r / 4;
    q[j] = (at(j, i) + at(i, j)) / r;
    q[k] = (at(k, i) + at(i, k)) / r;
    return q as never;
}

function slerp(a: Quaternion, b: Quaternion, s: number): Quaternion {
    let cosine = a.reduce((sum, x, i) => sum + x * b[i]!, 0);
    const sign = cosine < 0 ? -1 : 1; // the shorter arc
    cosine = Math.min(cosine * sign, 1);
    const angle = Math.acos(cosine);
    const sine = Math.sin(angle);
    const [u, v] =
        sine > 1e-6 ? [Math.sin((1 - s) * angle) / sine, Math.sin(s * angle) / sine] : [1 - s, s];
    const sum = a.map((x, i) => u * x + v * sign * b[i]!);
    const length = Math.hypot(...sum);
    return sum.map((x) => x / length) as never;
}

function directionsOf([x, y, z, w]: Quaternion): { look: Vec3; up: Vec3 } {
    return {
        look: [-2 * (x * z + w * y), -2 * (y * z - w * x), -1 + 2 * (x * x + y * y)],
        up: [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
    };
}

// --- files

const kName = 'pliant keyframes';

export function writeKeyframes(frames: readonly Keyframe[]): string {
    const times = timesOf(frames);
    const file = {
        what: kName,
        version: 1,
        keyframes: frames.map((frame, i) => ({
            seconds: times[i]!,
            eye_mm: frame.camera.eye,
            look: frame.camera.look,
            up: frame.camera.up,
            field_of_view_deg: frame.fieldOfView,
            iso_hu: frame.iso,
            window_hu: frame.window,
            level_hu: frame.level,
        })),
    };
    return JSON.stringify(file, null, 1) + '\n';
}

export function isKeyframes(text: string): boolean {
    try {
        return JSON.parse(text)?.what === kName;
    } catch {
        return false;
    }
}

/// Parses the text of writeKeyframes. @throws an Error that names the wrong field
export function readKeyframes(text: string, name: string): Keyframe[] {
    let file: { what?: unknown; version?: unknown; keyframes?: unknown };
    try {
        file = JSON.parse(text);
    } catch {
        throw new Error(`${name}: expected keyframes (JSON), found no JSON`);
    }
    if (file?.what !== kName) throw new Error(`${name}: what: expected "${kName}"`);
    if (file.version !== 1) throw new Error(`${name}: version: expected 1`);
    if (!Array.isArray(file.keyframes) || !file.keyframes.length)
        throw new Error(`${name}: keyframes: expected a list`);
    let before = 0;
    return file.keyframes.map((frame: Record<string, unknown> | null, i): Keyframe => {
        const where = `${name}: keyframes[${i}]`;
        const number = (key: string, low: number, high: number): number => {
            const x = frame?.[key];
            if (typeof x !== 'number' || !(x >= low && x <= high))
                throw new Error(`${where}.${key}: expected a number ${low}…${high}`);
            return x;
        };
        const vector = (key: string): Vec3 => {
            const v = frame?.[key] as number[];
            if (!Array.isArray(v) || v.length !== 3 || !v.every(Number.isFinite))
                throw new Error(`${where}.${key}: expected three numbers`);
            return v as never;
        };
        const direction = (key: string): Vec3 => {
            const v = vector(key);
            if (!(norm(v) > 0)) throw new Error(`${where}.${key}: expected a direction`);
            return v;
        };
        const time = number('seconds', 0, 36000);
        if (i === 0 ? time !== 0 : !(time > before))
            throw new Error(`${where}.seconds: expected ${i === 0 ? '0' : `more than ${before}`}`);
        const seconds = time - before;
        before = time;
        return {
            seconds,
            camera: { eye: vector('eye_mm'), look: direction('look'), up: direction('up') },
            fieldOfView: number('field_of_view_deg', 10, 150),
            iso: number('iso_hu', -65504, 65504),
            window: number('window_hu', 1, 65536),
            level: number('level_hu', -65536, 65536),
        };
    });
}
