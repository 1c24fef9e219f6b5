// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panels of this client's own view: window, endoscope, places, display.

import { autoWindow } from '../maths/auto_window.ts';
import type { VolumeInfo } from '../net/protocol.ts';
import { kFieldStops, kLinings } from '../state/state.ts';
import { isInHu, lengthLimits, valueStep, widthLimits, windowOf } from '../state/units.ts';
import { button, checkbox, choice, h } from './dom.ts';
import { type Preset, PresetShelf, presetsWithOwn } from './own_presets.ts';
import { type Parts, perScan, section } from './panel_parts.ts';

type WindowLevel = readonly [number, number];

const isWindowLevel = (value: unknown): value is WindowLevel =>
    Array.isArray(value) && value.length === 2 && value.every(Number.isFinite) && value[0] > 0;

const kCtWindows: readonly Preset<WindowLevel>[] = [
    { text: 'Soft tissue', value: [350, 50] },
    { text: 'Lung', value: [1500, -600] },
    { text: 'Mediastinum', value: [350, 40] },
    { text: 'Bone', value: [1000, 400] },
    { text: 'Air', value: [1000, -426] },
    { text: 'Brain', value: [80, 40] },
    { text: 'Vessels', value: [600, 300] },
    { text: 'All', value: [4000, 1000] },
];

/// Presets that suit the scan: those of CT; else the window of a fresh scan, and the whole range.
function windowsOf(scan: VolumeInfo | null): readonly Preset<WindowLevel>[] {
    if (isInHu(scan)) return kCtWindows;
    const [low, high] = scan!.range_hu;
    const { window, level } = windowOf(scan!);
    return [
        { text: 'As at the start', value: [window, level] },
        { text: 'All', value: [Math.max(high - low, valueStep(scan)), (low + high) / 2] },
    ];
}

export function windowPanel(parts: Parts): HTMLElement {
    const { store, history } = parts.session;
    const auto = (): void => {
        const { volume } = parts.session;
        const step = valueStep(store.state.scan.volume);
        if (volume) history.step('window', () => store.set({ sections: autoWindow(volume, step) }));
    };
    const ct = { unit: 'HU', low: 1, high: 4000, step: 1 };
    const presets = perScan(parts, windowsOf);
    return section(
        'Window',
        true,
        parts.number('sections', 'window', {
            label: 'Window',
            ...ct,
            limits: () => widthLimits(store.state.scan.volume, ct),
            curved: true,
        }),
        parts.number('sections', 'level', {
            label: 'Level',
            unit: 'HU',
            low: -1000,
            high: 2000,
            step: 1,
        }),
        parts.add(
            presetsWithOwn<WindowLevel>(
                'Presets of window and level',
                presets,
                new PresetShelf(localStorage, 'pliant.presets.window', isWindowLevel),
                () => [store.state.sections.window, store.state.sections.level],
                ([window, level]) =>
                    history.step('window', () => store.set({ sections: { window, level } })),
                (text) => parts.session.say(text),
            ),
        ),
        h(
            'div',
            { class: 'row' },
            button('Automatic', auto, 'window and level from the values of the scan'),
        ),
    );
}

export function endoscopePanel(parts: Parts): HTMLElement {
    const { store } = parts.session;
    return section(
        'Endoscope',
        true,
        parts.add(
            choice(
                'At walls the tip',
                [
                    { value: 'stop', text: 'stops' },
                    { value: 'push', text: 'pushes' },
                    { value: 'pass', text: 'passes' },
                ],
                () => parts.state.flight.wall,
                (wall) => parts.actions.setWall(wall),
            ),
        ),
        ...look(parts),
        h(
            'div',
            { class: 'row' },
            button(
                'Endoscope here',
                () => parts.actions.endoscopeTo(parts.state.sections.cursor),
                'the endoscope comes to the crosshair (J)',
            ),
        ),
        path(parts),
        parts.number('flight', 'tip', {
            label: 'Tip',
            unit: 'mm',
            low: 0.5,
            high: 8,
            step: 0.5,
            hint: 'radius',
        }),
        parts.number('flight', 'speed', {
            label: 'Speed',
            unit: '×',
            low: 0.1,
            high: 4,
            step: 0.1,
            curved: true,
        }),
        parts.number('view', 'fieldOfView', {
            label: 'Field of view',
            unit: '°',
            low: 30,
            high: 120,
            step: 1,
        }),
        parts.number('view', 'barrel', {
            label: 'Lens distortion',
            unit: '',
            low: 0,
            high: 0.5,
            step: 0.01,
        }),
        parts.number('view', 'fog', {
            label: 'Fog',
            unit: 'mm',
            low: 0,
            high: 500,
            step: 5,
            hint: '0: none',
            curved: true,
        }),
        parts.add(
            checkbox(
                'from outside, cut open',
                () => parts.state.view.outside,
                (on) => {
                    if (on !== store.state.view.outside) parts.actions.toggleOutside();
                },
            ),
        ),
    );
}

/// Creates the controls of the picture's style, colours and shape.
function look(parts: Parts): HTMLElement[] {
    const { store } = parts.session;
    const lining = choice(
        'Colours of',
        (['auto', ...kLinings] as const).map((value) => ({ value, text: value })),
        () => parts.state.look.lining,
        (chosen) => store.set({ look: { lining: chosen } }),
    );
    const field = choice(
        'Field',
        kFieldStops.map((value) => ({ value, text: value })),
        () => parts.state.look.fieldStop,
        (fieldStop) => store.set({ look: { fieldStop } }),
    );
    store.watch(
        ({ look }) => [look],
        ({ style }) => {
            lining.element.hidden = style !== 'real';
            field.element.hidden = style !== 'real';
        },
    );
    const style = choice(
        'Look',
        [
            { value: 'real', text: 'real', hint: 'lamps, tissue colours, wet surface' },
            { value: 'plain', text: 'plain', hint: 'shaded shape; faster to draw' },
        ],
        () => parts.state.look.style,
        (chosen) => store.set({ look: { style: chosen, styleChosen: true } }),
    );
    return [parts.add(style), parts.add(lining), parts.add(field)];
}

function path(parts: Parts): HTMLElement {
    const { session } = parts;
    const file = h('input', {
        type: 'file',
        accept: '.json',
        hidden: true,
        'aria-label': 'path file',
        onchange: () => {
            const chosen = file.files?.[0];
            if (chosen) void parts.actions.openFile(chosen);
            file.value = '';
        },
    });
    const fly = button('Fly', () => session.path.toggle(), 'flies along the path, or pauses');
    const ofPath = { unit: 'mm', low: 0, high: 1, step: 0.5 };
    const position = parts.slider({
        label: 'Along the path',
        ...ofPath,
        limits: () => {
            const { scan, way } = session.store.state;
            const limits = lengthLimits(scan.volume, ofPath);
            return { ...limits, high: way.path?.length ?? limits.high };
        },
        value: () => parts.state.way.position,
        input: (value) => session.path.goTo(value),
        begin: () => session.history.begin(),
        end: () => session.history.end('path'),
    });
    const fromTip = button(
        'From tip',
        () => session.path.fromTip(),
        'finds a path from the endoscope to the next click',
    );
    const save = button('Save', () => session.path.saveFile(), 'saves the path (.mrk.json)');
    session.store.watch(
        ({ way }) => [way.path, way.flying, way.busy],
        (known, flying, busy) => {
            fly.disabled = save.disabled = !known;
            fly.setAttribute('aria-pressed', String(flying));
            position.hidden = !known;
            fromTip.disabled = busy;
        },
    );
    const load = button('Path…', () => file.click(), 'loads a path through the lumen (.mrk.json)');
    return h(
        'div',
        { class: 'body plain' },
        h('div', { class: 'row' }, load, fly, fromTip, save, file),
        position,
    );
}

export function placesPanel(parts: Parts): HTMLElement {
    const list = h('div', { class: 'column' });
    const { store, endoscope } = parts.session;
    store.watch(
        ({ scan: { volume } }) => [volume],
        (volume) => {
            const start = volume?.start;
            list.replaceChildren(
                ...(start
                    ? [button('Start', () => endoscope.goTo(start.eye_mm, start.look, start.up))]
                    : []),
                ...(volume?.landmarks ?? []).map((mark) =>
                    button(mark.name, () => endoscope.goTo(mark.eye_mm, mark.look)),
                ),
            );
        },
    );
    return section('Places', false, list);
}

export function displayPanel(parts: Parts): HTMLElement {
    const { store } = parts.session;
    return section(
        'Display',
        false,
        parts.add(
            choice(
                'Colours',
                [
                    { value: 'system', text: "system's" },
                    { value: 'light', text: 'light' },
                    { value: 'dark', text: 'dark' },
                ],
                () => parts.state.display.theme,
                (theme) => store.set({ display: { theme } }),
            ),
        ),
        parts.add(
            choice(
                'Coordinates',
                [
                    { value: 'LPS', text: 'LPS', hint: 'as in files' },
                    { value: 'RAS', text: 'RAS', hint: 'as 3D Slicer shows them' },
                ],
                () => parts.state.display.space,
                (space) => store.set({ display: { space } }),
            ),
        ),
        parts.add(
            checkbox(
                'finer picture when still',
                () => parts.state.display.fine,
                (fine) => store.set({ display: { fine } }),
            ),
        ),
        parts.add(
            checkbox(
                'times (T)',
                () => parts.state.display.timings,
                (timings) => store.set({ display: { timings } }),
            ),
        ),
        h(
            'div',
            { class: 'row' },
            button('Picture', () => void parts.actions.snapshot(), 'saves the views as PNG (P)'),
        ),
    );
}
