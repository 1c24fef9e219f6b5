// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Controls of the elastic scan: Young's modulus by value, Poisson's ratio, the threshold of bone.
// Each change makes the tissue anew.

import { countsOf, samplesOf } from '../maths/levels.ts';
import type { TissueState } from '../net/protocol.ts';
import { elasticRows, type ElasticSettings } from '../net/settings.ts';
import { type Limits, valueLimits } from '../state/units.ts';
import { h, type SliderSettings } from './dom.ts';
import { ModulusCurve } from './modulus_curve.ts';
import type { Parts } from './panel_parts.ts';

const kCt = { unit: 'HU', low: -1000, high: 1000, step: 10 };
const kBins = 100;

/// Summary of the elastic scan.
export const elasticText = (state: TissueState | undefined): string =>
    state?.model === 'elastic' ? `${(state.nodes as number).toLocaleString('en')} nodes` : '';

interface ElasticControls {
    element: HTMLElement;
    /// Settings of the last elastic scan of this scan of voxels, for the next one.
    settings(): Partial<ElasticSettings>;
}

/// Settings among the fields of a state.
export function settingsIn(state: TissueState): Partial<ElasticSettings> {
    const keys = Object.keys(elasticRows) as (keyof ElasticSettings)[];
    return Object.fromEntries(
        keys.filter((key) => state[key] !== undefined).map((key) => [key, state[key]]),
    );
}

/// @param make  called with all settings after a change of one
export function elasticControls(
    parts: Parts,
    make: (settings: Partial<ElasticSettings>) => void,
): ElasticControls {
    const { store } = parts.session;
    let used: Partial<ElasticSettings> = {};
    const limits = (): Limits => valueLimits(parts.state.scan.volume, kCt);
    const change = (changed: Partial<ElasticSettings>): void => make({ ...used, ...changed });
    const curve = new ModulusCurve(limits, (moduli) =>
        change({ moduli_kpa: moduli.map(([value, kpa]) => [value, kpa]) }),
    );
    /// A slider that changes the tissue when it is let go.
    const number = (
        key: 'poisson_ratio' | 'held_above_hu',
        settings: Omit<SliderSettings, 'value' | 'input'>,
    ): HTMLElement => {
        let wish: number | undefined;
        return parts.slider({
            ...settings,
            value: () => wish ?? used[key] ?? settings.low,
            input: (value) => {
                wish = value;
            },
            end: () => {
                if (wish !== undefined) change({ [key]: wish });
                wish = undefined;
            },
        });
    };
    const element = h(
        'div',
        {},
        curve.element,
        number('poisson_ratio', {
            label: "Poisson's ratio of tissue",
            unit: '',
            low: elasticRows.poisson_ratio.low!,
            high: 0.49,
            step: 0.01,
            hint: elasticRows.poisson_ratio.text,
        }),
        number('held_above_hu', {
            label: 'Bone above',
            ...kCt,
            hint: elasticRows.held_above_hu.text,
        }),
    );
    const show = (): void => {
        const state = parts.state.shared?.tissue;
        element.hidden = state?.model !== 'elastic';
        if (state?.model !== 'elastic') return;
        used = settingsIn(state);
        curve.show(used.moduli_kpa ?? [], used.held_above_hu);
    };
    store.watch(
        ({ scan }) => [scan.volume],
        () => {
            used = {};
            show();
        },
    );
    store.watch(
        ({ scan: { volume, loaded } }) => [loaded === 1 && volume],
        (volume) => {
            if (!volume) return;
            const { low, high } = limits();
            const values = samplesOf(parts.session.volume!.halves);
            curve.setHistogram(countsOf(values, low, high, kBins));
        },
    );
    store.watch(({ shared }) => [shared?.tissue], show);
    return { element, settings: () => used };
}
