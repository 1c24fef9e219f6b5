// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Half floats: 16 bits that represent every integer within ±2048, which covers most of the
// Hounsfield scale; larger values (metal) are rounded to steps of 2 and more. Textures hold them
// unchanged.

/// Value of each of the 65536 bit patterns.
export const floatOfHalf: Float32Array = (() => {
    const table = new Float32Array(65536);
    for (let bits = 0; bits < 65536; ++bits) {
        const exponent = (bits >> 10) & 31;
        const fraction = bits & 1023;
        const sign = bits & 0x8000 ? -1 : 1;
        if (exponent === 0) table[bits] = sign * fraction * 2 ** -24;
        else if (exponent === 31) table[bits] = fraction ? NaN : sign * Infinity;
        else table[bits] = sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
    }
    return table;
})();

/// Place of a half in the order of all values, 0…65535.
export const orderOfHalf = (half: number): number =>
    half ^ (half & 0x8000 ? 0xffff : 0x8000);
export const halfOfOrder = (order: number): number =>
    order ^ (order & 0x8000 ? 0x8000 : 0xffff);

const float = new Float32Array(1);
const word = new Uint32Array(float.buffer);

/// Rounds to the nearest half, ties to even; overflow becomes infinity.
export function halfOfFloat(value: number): number {
    float[0] = value;
    const bits = word[0]!;
    const sign = (bits >>> 16) & 0x8000;
    const magnitude = bits & 0x7fffffff;
    if (magnitude > 0x7f800000) return sign | 0x7e00;
    if (magnitude >= 0x47800000) return sign | 0x7c00;
    if (magnitude < 0x38800000) {
        // Below 2^-14 halves are whole multiples of 2^-24; the addition rounds to them.
        float[0] = Math.abs(float[0]!) + 0.5;
        return sign | (word[0]! - 0x3f000000);
    }
    const rounded = magnitude + 0xfff + ((magnitude >>> 13) & 1);
    return sign | Math.min((rounded - 0x38000000) >>> 13, 0x7c00);
}

/// Half of each 16-bit integer, indexed by value & 0xffff.
export const halfOfInt16: Uint16Array = (() => {
    const table = new Uint16Array(65536);
    for (let value = -32768; value < 32768; ++value) table[value & 0xffff] = halfOfFloat(value);
    return table;
})();
