// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Periodic value noise with its gradient: 16 cells, four samples per cell, as a texture. The same
// tile as in src/view/render/noise_tile.cpp.

import * as THREE from 'three';
import { halfOfFloat } from '../maths/half.ts';

const kCells = 16;
const kSamples = 4 * kCells;

/// Value of a lattice point: uniform in 0…1, in steps of 1/256.
export function latticeValue(x: number, y: number, z: number): number {
    const wrapped = (i: number): number => i & (kCells - 1);
    let h = wrapped(x) | (wrapped(y) << 4) | (wrapped(z) << 8);
    h = Math.imul(h + 1, 0x9e3779b1);
    h = Math.imul(h ^ (h >>> 16), 0x85ebca6b);
    h = Math.imul(h ^ (h >>> 13), 0xc2b2ae35);
    h ^= h >>> 16;
    return ((h >>> 24) + 0.5) / 256;
}

const fade = (f: number): number => f * f * (3 - 2 * f);
const fadeSlope = (f: number): number => 6 * f * (1 - f);

/// Gradient per cell and value of each sample, x fastest, as half floats.
export function noiseTile(): Uint16Array {
    const lattice = new Float64Array(kCells ** 3);
    for (let n = 0; n < lattice.length; ++n)
        lattice[n] = latticeValue(n & 15, (n >> 4) & 15, n >> 8);
    const at = (x: number, y: number, z: number): number =>
        lattice[(x & 15) | ((y & 15) << 4) | ((z & 15) << 8)]!;
    const tile = new Uint16Array(4 * kSamples ** 3);
    const weight = [0, 1, 2, 3].map((n) => fade(n / 4));
    const slope = [0, 1, 2, 3].map((n) => fadeSlope(n / 4));
    let next = 0;
    for (let k = 0; k < kSamples; ++k)
        for (let j = 0; j < kSamples; ++j)
            for (let i = 0; i < kSamples; ++i) {
                const [x, y, z] = [i >> 2, j >> 2, k >> 2];
                const [fx, fy, fz] = [weight[i & 3]!, weight[j & 3]!, weight[k & 3]!];
                // Along x first: values and slopes on the four edges.
                const edge = (dy: number, dz: number): [number, number] => {
                    const a = at(x, y + dy, z + dz);
                    const d = at(x + 1, y + dy, z + dz) - a;
                    return [a + fx * d, slope[i & 3]! * d];
                };
                const [v00, s00] = edge(0, 0);
                const [v10, s10] = edge(1, 0);
                const [v01, s01] = edge(0, 1);
                const [v11, s11] = edge(1, 1);
                const near = v00 + fy * (v10 - v00);
                const far = v01 + fy * (v11 - v01);
                const nearX = s00 + fy * (s10 - s00);
                const farX = s01 + fy * (s11 - s01);
                const slopeY = v10 - v00 + fz * (v11 - v01 - (v10 - v00));
                tile[next++] = halfOfFloat(nearX + fz * (farX - nearX));
                tile[next++] = halfOfFloat(slope[j & 3]! * slopeY);
                tile[next++] = halfOfFloat(slope[k & 3]! * (far - near));
                tile[next++] = halfOfFloat(near + fz * (far - near));
            }
    return tile;
}

export function noiseTexture(): THREE.Data3DTexture {
    const texture = new THREE.Data3DTexture(noiseTile(), kSamples, kSamples, kSamples);
    texture.format = THREE.RGBAFormat;
    texture.type = THREE.HalfFloatType;
    texture.minFilter = THREE.LinearFilter;
    texture.magFilter = THREE.LinearFilter;
    texture.wrapS = THREE.RepeatWrapping;
    texture.wrapT = THREE.RepeatWrapping;
    texture.wrapR = THREE.RepeatWrapping;
    texture.unpackAlignment = 2;
    texture.needsUpdate = true;
    return texture;
}
