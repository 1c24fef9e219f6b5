// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panels of tool, threshold and material.

import type { Polarity, VolumeInfo } from '../net/protocol.ts';
import { materialRows, type Materials } from '../net/settings.ts';
import { hasMaterials, type State } from '../state/state.ts';
import { isInHu, kMaxThreshold, type Limits, valueLimits } from '../state/units.ts';
import { button, checkbox, choice, h } from './dom.ts';
import { type Preset, PresetShelf, presetsWithOwn } from './own_presets.ts';
import { type Parts, perScan, section, tissue } from './panel_parts.ts';

interface Threshold {
    iso_hu: number;
    polarity: Polarity;
}

function isThreshold(value: unknown): value is Threshold {
    const { iso_hu, polarity } = (value ?? {}) as Partial<Threshold>;
    return (
        Number.isFinite(iso_hu) &&
        Math.abs(iso_hu!) <= kMaxThreshold &&
        (polarity === 'rising' || polarity === 'falling')
    );
}

const kCtThresholds: readonly Preset<Threshold>[] = [
    { text: 'Airway, bowel, sinus', value: { iso_hu: -500, polarity: 'rising' } },
    { text: 'Skin', value: { iso_hu: -300, polarity: 'rising' } },
    { text: 'Bone', value: { iso_hu: 250, polarity: 'rising' } },
    { text: 'Vessel with contrast', value: { iso_hu: 170, polarity: 'falling' } },
];

/// Presets that suit the scan: those of CT, or the server's threshold.
function thresholdsOf(scan: VolumeInfo | null): readonly Preset<Threshold>[] {
    if (isInHu(scan)) return kCtThresholds;
    const { iso, polarity } = scan!.values!;
    return [{ text: 'Automatic', value: { iso_hu: iso, polarity } }];
}

export function toolPanel(parts: Parts): HTMLElement {
    const { session, actions } = parts;
    const relax = button('Relax', () => actions.relax(), 'tissue springs back by itself (X)');
    session.store.watch(
        ({ shared }) => [shared],
        (shared) => {
            relax.setAttribute('aria-pressed', String(shared?.relaxing ?? false));
        },
    );
    const small = h('small', { class: 'quiet' });
    session.store.watch(
        ({ shared, tool }) => [shared, tool.radius],
        (shared, radius) => {
            const edge = shared?.tissue?.edge_mm ?? 0;
            small.hidden = radius >= edge;
            small.textContent =
                `smaller than the tetrahedra, whose edges are ${edge.toPrecision(2)} mm: ` +
                'it holds few of their nodes';
        },
    );
    return section(
        'Tool',
        true,
        tissue(
            parts.number('tool', 'radius', {
                label: 'Size',
                unit: 'mm',
                low: 0,
                high: 30,
                step: 0.5,
                curved: true,
                hint: 'radius of the tool; 0: the eight elements of one cell, for Push and Grab',
            }),
            small,
            parts.number('tool', 'strength', {
                label: 'Strength',
                unit: '×',
                low: 0.1,
                high: 2,
                step: 0.1,
                hint: 'motion of the tool over motion of the pointer',
            }),
            parts.number('tool', 'depth', {
                label: 'Cut depth',
                unit: 'mm',
                low: 1,
                high: 60,
                step: 1,
                curved: true,
            }),
            parts.add(
                checkbox(
                    'tissue slides off the probe',
                    () => parts.state.tool.slide,
                    (slide) => session.store.set({ tool: { slide } }),
                    'off: the probe drags the tissue that it touches',
                ),
            ),
            parts.add(
                checkbox(
                    'sections follow the tool',
                    () => parts.state.tool.follow,
                    (follow) => session.store.set({ tool: { follow } }),
                    'the crosshair goes with the tool, or the tip of a catheter, while it moves',
                ),
            ),
            h(
                'div',
                { class: 'row' },
                relax,
                button(
                    'Let go',
                    () => void session.ask({ do: 'release' }),
                    'releases the tissue (L)',
                ),
                button(
                    'Reset',
                    () => void session.ask({ do: 'reset' }),
                    'moves all tissue back to rest',
                ),
            ),
        ),
    );
}

export function surfacePanel(parts: Parts): HTMLElement {
    const { threshold } = parts.session;
    const ct = { unit: 'HU', low: -1000, high: 1000, step: 5 };
    const iso = parts.slider({
        label: 'Threshold',
        ...ct,
        limits: () => {
            const limits = valueLimits(parts.state.scan.volume, ct);
            return { ...limits, high: Math.min(limits.high, kMaxThreshold) };
        },
        value: () => threshold.wanted,
        input: (iso_hu) => threshold.ask({ iso_hu }),
    });
    const presets = perScan(parts, thresholdsOf);
    return section(
        'Surface',
        true,
        tissue(
            iso,
            parts.add(
                choice(
                    'Lumen',
                    [
                        {
                            value: 'rising',
                            text: 'air',
                            hint: 'the wall is brighter than the lumen',
                        },
                        {
                            value: 'falling',
                            text: 'contrast',
                            hint: 'the wall is darker than the lumen',
                        },
                    ],
                    () => parts.state.shared?.polarity ?? 'rising',
                    (polarity) => threshold.ask({ polarity }),
                ),
            ),
            parts.add(
                presetsWithOwn<Threshold>(
                    'Presets of the threshold',
                    presets,
                    new PresetShelf(localStorage, 'pliant.presets.iso', isThreshold),
                    () => ({
                        iso_hu: threshold.wanted,
                        polarity: parts.state.shared?.polarity ?? 'rising',
                    }),
                    (value) => threshold.ask(value),
                    (text) => parts.session.say(text),
                ),
            ),
            h(
                'div',
                { class: 'row' },
                button(
                    'Close walls',
                    () => parts.actions.closeWalls(),
                    'sets the threshold at which the lumen around the endoscope does not leak ' +
                        'through its walls',
                ),
            ),
        ),
        parts.add(
            checkbox(
                'as a line in the sections',
                () => parts.state.display.contour,
                (contour) => parts.session.store.set({ display: { contour } }),
            ),
        ),
    );
}

export function materialPanel(parts: Parts): HTMLElement {
    const settings = tissue(
        materialNumber(parts, 'offset', 'Softness', 0.01),
        materialNumber(parts, 'max_movement_mm', 'Largest movement', 1, 0, 100),
        materialNumber(parts, 'bone_threshold_hu', 'Bone above', 10, 0, 2000, boneLimits),
        materialNumber(parts, 'yield', 'Stays deformed', 0.01),
        parts.add(
            checkbox(
                'air is a material of its own',
                () => parts.state.shared?.materials.air_enabled ?? false,
                (on) => void parts.session.ask({ do: 'materials', air_enabled: on }),
            ),
        ),
        materialNumber(parts, 'air_threshold_hu', 'Air below', 10, -1000, 0),
        parts.add(
            checkbox(
                'air is what the threshold shows as empty',
                () => parts.state.display.airFollows,
                (on) => parts.session.threshold.tieAir(on),
            ),
        ),
        parts.add(
            choice<Materials['limits']>(
                'Deforms as',
                [
                    { value: 'rounded', text: 'round', hint: 'dents are round' },
                    { value: 'box', text: 'diamond', hint: 'the limits of ChainMail' },
                ],
                () => parts.state.shared?.materials.limits ?? 'box',
                (limits) => {
                    parts.session.tissueDefaults.keep({ limits });
                    void parts.session.ask({ do: 'materials', limits });
                },
            ),
        ),
    );
    const none = h(
        'small',
        { class: 'quiet' },
        'for ChainMail; the settings of this tissue are in Tissue',
    );
    const element = section('Material', false, settings, none);
    parts.session.store.watch(
        ({ shared }) => [shared],
        (shared) => {
            element.hidden = shared?.tissue?.model === 'own';
            settings.hidden = !hasMaterials(parts.state);
            none.hidden = !settings.hidden;
        },
    );
    return element;
}

/// Limits of the bone's threshold. Without HU nothing is bone at first: they include the hardest
/// value.
function boneLimits({ scan, shared }: State, ct: Limits): Limits {
    const limits = valueLimits(scan.volume, ct);
    const hardest = shared?.materials.range?.[1] ?? limits.high;
    return isInHu(scan.volume) ? ct : { ...limits, high: Math.max(limits.high, hardest) };
}

/// Creates a slider for a setting, with unit, hint and range of its row.
function materialNumber(
    parts: Parts,
    key: keyof { [K in keyof Materials as Materials[K] extends number ? K : never]: 0 },
    label: string,
    step: number,
    low = materialRows[key].low ?? 0,
    high = materialRows[key].high ?? 1,
    limitsOf?: (state: State, ct: Limits) => Limits,
): HTMLElement {
    let wish: number | undefined; // sent once, when the slider is let go
    const limits = { unit: materialRows[key].unit, low, high, step };
    return parts.slider({
        label,
        ...limits,
        ...(limitsOf ? { limits: () => limitsOf(parts.state, limits) } : {}),
        hint: materialRows[key].text,
        value: () => wish ?? parts.state.shared?.materials[key] ?? low,
        input: (value) => {
            wish = value;
        },
        end: () => {
            if (wish !== undefined) void parts.session.ask({ do: 'materials', [key]: wish });
            wish = undefined;
        },
    });
}
