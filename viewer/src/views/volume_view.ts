// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parameters of the volume rendering shader (shaders/blend.frag.glsl) and of slabs in the sections
// (shaders/slab.glsl).

import * as THREE from 'three';
import { type Grid, voxelVector } from '../maths/grid.ts';
import { adjusted, emptyRanges, kMaxPoints, linearOf, steepOf } from '../maths/transfer.ts';
import { mul } from '../maths/vec.ts';
import { kProjections, type State, tipIsInScan } from '../state/state.ts';
import { orbitCamera } from './orbit.ts';
import type { SectionPlane } from './section_geometry.ts';

const kMaxEmpty = 4; // as in the shader
const kFineStep = 0.5; // of the smallest voxel spacing, as in C++
const kCoarseStep = 1;
const kFineDark = 1e-3; // transmittance at which rays end, as in C++
const kCoarseDark = 1e-2;
const kFar = 1e30; // stands for infinity in uniforms

const vectors4 = (length: number): THREE.Vector4[] =>
    Array.from({ length }, () => new THREE.Vector4());
const vectors2 = (length: number): THREE.Vector2[] =>
    Array.from({ length }, () => new THREE.Vector2());

/// Uniforms without a transfer function, to create the material.
export const kNoTransfer = (): Record<string, unknown> => ({
    cut: false,
    cutPlace: new THREE.Vector3(),
    cutNormal: new THREE.Vector3(),
    transfer: vectors4(kMaxPoints),
    transferValues: vectors2(kMaxPoints),
    transferCount: 0,
    empty: vectors2(kMaxEmpty),
    steep: 1,
    stride: 1,
    dark: kFineDark,
    phase: 0,
});

/// Uniforms of the volume rendering. @param coarse  longer steps, and shorter rays
export function transferUniforms(
    state: State,
    grid: Grid,
    coarse: boolean,
    phase: number,
): Record<string, unknown> {
    const { transfer, opacity, shift, cut } = state.rendering;
    const points = adjusted(transfer, opacity, shift);
    const colours = vectors4(kMaxPoints);
    const values = vectors2(kMaxPoints);
    points.forEach(({ value, perMm, colour }, i) => {
        const [r, g, b] = colour.map(linearOf) as [number, number, number];
        const width = Math.max(value - (points[i - 1]?.value ?? value), 1e-6);
        colours[i]!.set(r, g, b, perMm);
        values[i]!.set(value, 1 / width);
    });
    const empty = vectors2(kMaxEmpty);
    const ranges = emptyRanges(points);
    empty.forEach((pair, i) => {
        const [low, high] = ranges[i] ?? [kFar, -kFar];
        pair.set(Math.max(low, -kFar), Math.min(high, kFar));
    });
    return {
        cut: cut && tipIsInScan(state),
        cutPlace: new THREE.Vector3(...state.view.camera.eye),
        cutNormal: new THREE.Vector3(...mul(-1, orbitCamera(state.view).look)),
        transfer: colours,
        transferValues: values,
        transferCount: points.length,
        empty,
        steep: steepOf(points),
        stride: (coarse ? kCoarseStep : kFineStep) * Math.min(...grid.spacing),
        dark: coarse ? kCoarseDark : kFineDark,
        phase,
    };
}

/// Uniforms of a section without a slab, to create the material.
export const kNoSlab: Record<string, unknown> = {
    slab: 0,
    slabAxis: new THREE.Vector3(0, 0, 1),
    projection: 0,
};

/// Uniforms of a section's slab.
export function slabUniforms(
    { slab, projection }: State['sections'],
    grid: Grid,
    { axes }: SectionPlane,
): Record<string, unknown> {
    return {
        slab,
        slabAxis: new THREE.Vector3(...voxelVector(grid, axes.normal)),
        projection: kProjections.indexOf(projection),
    };
}
