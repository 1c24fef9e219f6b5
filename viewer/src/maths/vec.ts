// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Vectors in three dimensions, as plain triples: world coordinates [mm, LPS] or voxel indices.
// three.js is used to draw only.

export type Vec3 = readonly [number, number, number];

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const mul = (s: number, a: Vec3): Vec3 => [s * a[0], s * a[1], s * a[2]];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const norm = (a: Vec3): number => Math.hypot(a[0], a[1], a[2]);
export const cross = (a: Vec3, b: Vec3): Vec3 => [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
];

/// Unit vector along a; (0, 0, 1) if a is zero.
export function normalized(a: Vec3): Vec3 {
    const length = norm(a);
    return length > 0 ? mul(1 / length, a) : [0, 0, 1];
}

/// a + s·b
export const along = (a: Vec3, s: number, b: Vec3): Vec3 => [
    a[0] + s * b[0],
    a[1] + s * b[1],
    a[2] + s * b[2],
];

/// Rotates v about a unit axis, right-handed [radians].
export function turned(v: Vec3, axis: Vec3, angle: number): Vec3 {
    const c = Math.cos(angle);
    const s = Math.sin(angle);
    return add(add(mul(c, v), mul(s, cross(axis, v))), mul((1 - c) * dot(axis, v), axis));
}

/// Matrix as three columns.
export type Mat3 = readonly [Vec3, Vec3, Vec3];

export const apply = (m: Mat3, v: Vec3): Vec3 =>
    add(add(mul(v[0], m[0]), mul(v[1], m[1])), mul(v[2], m[2]));
/// Applies the transpose: the inverse, if the columns are orthonormal.
export const applyTransposed = (m: Mat3, v: Vec3): Vec3 => [
    dot(m[0], v),
    dot(m[1], v),
    dot(m[2], v),
];
