// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// MurmurHash3, x86, 32 bits, seed 0: the checksum of a client's voxels
// (docs/developers/protocol.md). The algorithm is in the public domain, by Austin Appleby; written
// from its description.

function scrambled(k: number): number {
    k = Math.imul(k, 0xcc9e2d51);
    k = (k << 15) | (k >>> 17);
    return Math.imul(k, 0x1b873593);
}

export function murmur32(bytes: Uint8Array): number {
    let h = 0;
    const whole = bytes.length & ~3;
    for (let i = 0; i < whole; i += 4) {
        const k = bytes[i]! | (bytes[i + 1]! << 8) | (bytes[i + 2]! << 16) | (bytes[i + 3]! << 24);
        h ^= scrambled(k);
        h = (h << 13) | (h >>> 19);
        h = (Math.imul(h, 5) + 0xe6546b64) | 0;
    }
    let rest = 0;
    for (let i = bytes.length - 1; i >= whole; --i) rest = (rest << 8) | bytes[i]!;
    if (whole < bytes.length) h ^= scrambled(rest);
    h ^= bytes.length;
    h = Math.imul(h ^ (h >>> 16), 0x85ebca6b);
    h = Math.imul(h ^ (h >>> 13), 0xc2b2ae35);
    return (h ^ (h >>> 16)) >>> 0;
}

/// Checksum in the server's notation: 8 hexadecimal digits.
export const checksumOf = (halves: Uint16Array): string =>
    murmur32(new Uint8Array(halves.buffer, halves.byteOffset, halves.byteLength))
        .toString(16)
        .padStart(8, '0');
