// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Table of Young's moduli by voxel value, linear between its points, and its logarithmic axis.

/// Value and modulus [kPa]; 0: void.
export type Modulus = readonly [number, number];
/// Points by ascending value, at least one.
export type Moduli = readonly Modulus[];

export const kDecades = { low: 0.1, high: 1000 }; ///< of the axis [kPa]
const kVoid = 0.08; // height below which a modulus is 0

/// Height of a modulus on the axis, 0…1: voids are at 0.
export function heightOf(kpa: number): number {
    if (!(kpa > 0)) return 0;
    const share = Math.log(kpa / kDecades.low) / Math.log(kDecades.high / kDecades.low);
    return kVoid + (1 - kVoid) * Math.min(Math.max(share, 0), 1);
}

/// Modulus at a height, to two digits.
export function kpaAt(height: number): number {
    if (height < 0.5 * kVoid) return 0;
    const share = Math.min(Math.max((height - kVoid) / (1 - kVoid), 0), 1);
    const kpa = kDecades.low * (kDecades.high / kDecades.low) ** share;
    return Number(kpa.toPrecision(2));
}

/// Modulus of a value.
export function modulusAt(moduli: Moduli, value: number): number {
    let kpa = moduli[0]![1];
    for (let i = 1; i < moduli.length; ++i) {
        const [low, high] = [moduli[i - 1]!, moduli[i]!];
        const share = Math.min(Math.max((value - low[0]) / (high[0] - low[0]), 0), 1);
        kpa += share * (high[1] - low[1]);
    }
    return kpa;
}

const isTissue = (moduli: Moduli): boolean => moduli.some(([, kpa]) => kpa > 0);

/// Moves a point, between its neighbours. Unchanged if no tissue would be left.
export function withMoved(moduli: Moduli, at: number, to: Modulus, step: number): Moduli {
    const least = (moduli[at - 1]?.[0] ?? -Infinity) + step;
    const most = (moduli[at + 1]?.[0] ?? Infinity) - step;
    if (least > most) return moduli;
    const value = Math.min(Math.max(to[0], least), most);
    const next: Modulus = [value, Math.max(to[1], 0)];
    const moved = moduli.map((point, i) => (i === at ? next : point));
    return isTissue(moved) ? moved : moduli;
}

/// Adds a point. Unchanged if another one is nearer than a step.
export function withAdded(moduli: Moduli, point: Modulus, step: number): Moduli {
    if (moduli.some(([value]) => Math.abs(value - point[0]) < step)) return moduli;
    return [...moduli, point].sort((a, b) => a[0] - b[0]);
}

/// Removes a point. Unchanged if no tissue would be left.
export function withoutPoint(moduli: Moduli, at: number): Moduli {
    const left = moduli.filter((_, i) => i !== at);
    return isTissue(left) ? left : moduli;
}
