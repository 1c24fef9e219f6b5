// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Texture of a catheter for shaders/catheter.glsl: points of a smooth curve with their arc lengths
// from the tip, and two rows of bounding spheres of its segments.

import * as THREE from 'three';
import { norm, sub, type Vec3 } from '../maths/vec.ts';
import { distanceToSegment } from './instruments.ts';

export const kMaxPoints = 1024;
export const kGroup = 8; // as in the shader
const kMaxSwell = 2; // largest increase of the radius that a catheter is drawn with [mm]

/// Catmull-Rom curve through the points. @param parts  segments from one point to the next
export function smoothed(points: readonly Vec3[], parts = 3): Vec3[] {
    const curve: Vec3[] = [];
    const at = (n: number): Vec3 => points[Math.min(Math.max(n, 0), points.length - 1)]!;
    for (let n = 0; n + 1 < points.length; ++n)
        for (let k = 0; k < parts; ++k) {
            const t = k / parts;
            const weights = [
                -t + 2 * t * t - t ** 3,
                2 - 5 * t * t + 3 * t ** 3,
                t + 4 * t * t - 3 * t ** 3,
                -t * t + t ** 3,
            ];
            const p: [number, number, number] = [0, 0, 0];
            weights.forEach((w, i) => {
                for (let a = 0; a < 3; ++a) p[a]! += (w / 2) * at(n - 1 + i)[a]!;
            });
            curve.push(p);
        }
    if (points.length) curve.push(points[points.length - 1]!);
    return curve;
}

/// Curve to draw: as many points as fit into the texture.
export function drawnCurve(points: readonly Vec3[]): Vec3[] {
    const pieces = Math.max(points.length - 1, 1);
    const parts = Math.min(3, Math.floor((kMaxPoints - 1) / pieces));
    if (parts > 0) return smoothed(points, parts);
    return Array.from(
        { length: kMaxPoints },
        (_, i) => points[Math.round((i * pieces) / (kMaxPoints - 1))]!,
    );
}

/// Rows of the texture: x, y, z [mm, LPS] and arc length from the tip [mm] of each point; centres
/// and radii of the spheres.
export function catheterRows(curve: readonly Vec3[], radius: number): Float32Array {
    const rows = new Float32Array(3 * 4 * kMaxPoints);
    let way = 0;
    for (let i = curve.length - 1; i >= 0; --i) {
        if (i + 1 < curve.length) way += norm(sub(curve[i + 1]!, curve[i]!));
        rows.set([...curve[i]!, way], 4 * i);
    }
    const pieces = curve.length - 1;
    for (let row = 1, each = kGroup; row <= 2; ++row, each *= kGroup)
        for (let g = 0; g * each < pieces; ++g) {
            const part = curve.slice(g * each, Math.min((g + 1) * each, pieces) + 1);
            rows.set(sphereAround(part, radius), 4 * (row * kMaxPoints + g));
        }
    return rows;
}

function sphereAround(points: readonly Vec3[], radius: number): [number, number, number, number] {
    const axes = [0, 1, 2] as const;
    const low = axes.map((a) => Math.min(...points.map((p) => p[a])));
    const high = axes.map((a) => Math.max(...points.map((p) => p[a])));
    const centre = axes.map((a) => 0.5 * (low[a]! + high[a]!)) as unknown as Vec3;
    const farthest = Math.max(...points.map((p) => norm(sub(p, centre))));
    return [...centre, farthest + radius + kMaxSwell];
}

/// Range of segments to leave out around an eye inside of the catheter: first, and past the last.
export function gapAround(eye: Vec3, curve: readonly Vec3[], radius: number): [number, number] {
    const away = (i: number): number => distanceToSegment(eye, curve[i]!, curve[i + 1]!);
    let nearest = -1;
    for (let i = 0; i + 1 < curve.length; ++i)
        if (away(i) < 1.05 * radius && (nearest < 0 || away(i) < away(nearest))) nearest = i;
    if (nearest < 0) return [0, 0];
    let [from, to] = [nearest, nearest + 1];
    while (from > 0 && away(from - 1) < 3 * radius) --from;
    while (to + 1 < curve.length && away(to) < 3 * radius) ++to;
    return [from, to];
}

/// Uniforms without a catheter, to create the material.
export const kNoCatheter = (): Record<string, unknown> => ({
    catheter: null,
    catheterCount: 0,
    catheterRadius: 1,
    catheterGap: new THREE.Vector2(),
});

export class CatheterTexture {
    private curve: Vec3[] = [];
    private radius = 1;
    private readonly texture = new THREE.DataTexture(
        new Float32Array(3 * 4 * kMaxPoints),
        kMaxPoints,
        3,
        THREE.RGBAFormat,
        THREE.FloatType,
    );

    update(points: readonly Vec3[], radius: number): void {
        this.curve = points.length > 1 ? drawnCurve(points) : [];
        this.radius = radius;
        (this.texture.image.data as Float32Array).set(catheterRows(this.curve, radius));
        this.texture.needsUpdate = true;
    }

    get isThere(): boolean {
        return this.curve.length > 1;
    }

    dispose(): void {
        this.texture.dispose();
    }

    /// Uniforms of the shader. @param least  smallest radius to draw, so that it is visible from
    /// afar [mm]
    uniforms(eye: Vec3, least = 0): Record<string, unknown> {
        const radius = Math.min(Math.max(this.radius, least), this.radius + kMaxSwell);
        return {
            catheter: this.texture,
            catheterCount: this.curve.length,
            catheterRadius: radius,
            catheterGap: new THREE.Vector2(...gapAround(eye, this.curve, this.radius)),
        };
    }
}
