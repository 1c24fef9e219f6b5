// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Reproducible random numbers: the seed is printed, and PLIANT_SEED sets it.

const seed = Number(process.env.PLIANT_SEED ?? Math.floor(Math.random() * 2 ** 31));
console.log(`# seed ${seed}`);
let state = seed >>> 0;

/// Uniform in 0 ≤ x < 1, by a 32-bit mix of a counter.
export function random(): number {
    state = (state + 0x9e3779b9) >>> 0;
    let z = state;
    z = Math.imul(z ^ (z >>> 16), 0x85ebca6b);
    z = Math.imul(z ^ (z >>> 13), 0xc2b2ae35);
    return ((z ^ (z >>> 16)) >>> 0) / 2 ** 32;
}

export const between = (low: number, high: number): number => low + (high - low) * random();
export const whole = (low: number, high: number): number => Math.floor(between(low, high + 1));
