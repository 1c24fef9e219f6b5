// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Labels of the deformed scan on its grid: numbers in the list of labels, from 1; 0 without one.
// Numbers of bodies are negative in every other cube of the tissue at rest.

import * as THREE from 'three';
import type { Grid } from '../maths/grid.ts';
import { floatOfHalf } from '../maths/half.ts';
import type { Vec3 } from '../maths/vec.ts';
import { haveBodies, kMaxLabels, type Label, lookOf, type State } from '../state/labels.ts';
import { HalfField } from './half_field.ts';

const kWidth = kMaxLabels + 1;
const kShown = 64; // as in shaders/labels.glsl
const kTarget = 128;
const kBodies = 63; // numbers of bodies in the colours; further ones share them

export class LabelField extends HalfField {
    /// Creates a field without labels.
    constructor(readonly grid: Grid) {
        super('labels', grid.size, 1);
        this.texture.minFilter = this.texture.magFilter = THREE.NearestFilter;
    }

    /// Number at the nearest voxel; 0 outside of the scan.
    numberAt(ijk: Vec3): number {
        const at = ijk.map(Math.round);
        if (at.some((x, a) => x < 0 || x >= this.grid.size[a]!)) return 0;
        const [nx, ny] = this.grid.size;
        return Math.abs(floatOfHalf[this.halves[at[0]! + nx * (at[1]! + ny * at[2]!)]!]!);
    }
}

/// Colours by number, for the shaders.
export class LabelColours {
    private readonly data = new Uint8Array(4 * kWidth);
    private readonly texture = new THREE.DataTexture(this.data, kWidth, 1);
    private shown: unknown;

    constructor() {
        this.texture.minFilter = this.texture.magFilter = THREE.NearestFilter;
    }

    /// Uniforms of shaders/labels.glsl.
    uniforms(state: State, field: LabelField | undefined): Record<string, unknown> {
        const { labels } = state;
        if (this.shown !== labels) this.update(labels.list, labels);
        this.shown = labels;
        return {
            labelField: field?.texture ?? null,
            labelColours: this.texture,
            labelOpacity: labels.opacity,
            labelOutlines: labels.outline,
            contactsOn: labels.contact && haveBodies(labels),
            targetsOn: labels.list.some((label) => lookOf(labels, label).target),
        };
    }

    dispose(): void {
        this.texture.dispose();
    }

    private update(list: readonly Label[], labels: State['labels']): void {
        this.data.fill(0);
        for (const label of list) {
            const { shown, target } = lookOf(labels, label);
            const at = 4 * label.number;
            label.colour.forEach((x, a) => {
                this.data[at + a] = Math.round(255 * x);
            });
            const body = label.body > 0 ? 1 + ((label.body - 1) % kBodies) : 0;
            this.data[at + 3] = (shown ? kShown : 0) + (target ? kTarget : 0) + body;
        }
        this.texture.needsUpdate = true;
    }
}

export const kNoLabels: Record<string, unknown> = {
    labelField: null,
    labelColours: null,
    labelOpacity: 0,
    labelOutlines: false,
    contactsOn: false,
    targetsOn: false,
};
