// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Colours of tissues behind a wall for each kind of lumen: the table of src/view/render/lining.h.

import * as THREE from 'three';
import type { Lining } from '../state/state.ts';

/// Chosen lining, or the default for the threshold's polarity.
export const liningOf = (chosen: Lining | 'auto', rising: boolean): Lining =>
    chosen !== 'auto' ? chosen : rising ? 'airway' : 'vessel';

type Colour = readonly [number, number, number]; // linear

interface LiningColours {
    readonly mucosa: Colour;
    readonly pale: Colour;
    readonly fatty: Colour;
    readonly bony: Colour;
    readonly thinWall: Colour;
    readonly fatShare: number;
    readonly paleShare: number;
    readonly boneShare: number;
    readonly thinShare: number;
    readonly veinShare: number;
    readonly mottle: number;
    readonly gloss: number;
}

export const kColours: Record<Lining, LiningColours> = {
    airway: {
        mucosa: [0.67, 0.23, 0.165],
        pale: [0.8, 0.45, 0.35],
        fatty: [0.79, 0.38, 0.21],
        bony: [0.82, 0.6, 0.45],
        thinWall: [0.56, 0.14, 0.115],
        fatShare: 0.5,
        paleShare: 0.6,
        boneShare: 0.6,
        thinShare: 0.4,
        veinShare: 0.65,
        mottle: 0.55,
        gloss: 1.0,
    },
    colon: {
        mucosa: [0.66, 0.225, 0.15],
        pale: [0.74, 0.4, 0.31],
        fatty: [0.74, 0.33, 0.2],
        bony: [0.8, 0.62, 0.46],
        thinWall: [0.62, 0.19, 0.13],
        fatShare: 0.25,
        paleShare: 0.3,
        boneShare: 0.3,
        thinShare: 0.3,
        veinShare: 0.8,
        mottle: 0.5,
        gloss: 1.3,
    },
    sinus: {
        mucosa: [0.68, 0.225, 0.21],
        pale: [0.76, 0.4, 0.34],
        fatty: [0.76, 0.34, 0.25],
        bony: [0.8, 0.54, 0.42],
        thinWall: [0.6, 0.165, 0.15],
        fatShare: 0.3,
        paleShare: 0.4,
        boneShare: 0.3,
        thinShare: 0.25,
        veinShare: 0.45,
        mottle: 0.55,
        gloss: 1.2,
    },
    vessel: {
        mucosa: [0.73, 0.355, 0.26],
        pale: [0.8, 0.6, 0.46],
        fatty: [0.8, 0.48, 0.28],
        bony: [0.86, 0.74, 0.55],
        thinWall: [0.6, 0.24, 0.17],
        fatShare: 0.35,
        paleShare: 0.5,
        boneShare: 0.7,
        thinShare: 0.3,
        veinShare: 0.25,
        mottle: 0.45,
        gloss: 0.8,
    },
};

/// Uniforms of shaders/real.glsl for a lining.
export function liningUniforms(lining: Lining): Record<string, unknown> {
    return Object.fromEntries(
        Object.entries(kColours[lining]).map(([name, value]) => [
            name,
            typeof value === 'number' ? value : new THREE.Vector3(...(value as Colour)),
        ]),
    );
}
