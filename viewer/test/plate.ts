// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A small organ as a file.

/// A plate of 60 × 12 × 60 mm around the origin, as a surface.
export function plateStl(): Buffer {
    const half = [30, 6, 30];
    const corner = (n: number): number[] => half.map((x, a) => ((n >> a) & 1 ? x : -x));
    const faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    const triangles = faces.flatMap(([a, b, c, d]) => [
        [a!, b!, c!],
        [a!, c!, d!],
    ]);
    const stl = Buffer.alloc(84 + 50 * triangles.length);
    stl.writeUInt32LE(triangles.length, 80);
    triangles.forEach((triangle, t) =>
        triangle
            .flatMap(corner)
            .forEach((x, n) => stl.writeFloatLE(x, 84 + 50 * t + 12 + 4 * n)),
    );
    return stl;
}
