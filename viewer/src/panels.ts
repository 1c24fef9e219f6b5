// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The panels beside the views: every setting with its number, its unit and its preset.

import type { Actions } from './actions.ts';
import {
    button,
    checkbox,
    choice,
    type Control,
    h,
    presets,
    slider,
    type SliderSettings,
} from './dom.ts';
import type { Materials, Polarity } from './protocol.ts';
import type { Session } from './session.ts';
import type { State } from './store.ts';

const kWindows: readonly { text: string; value: readonly [number, number] }[] = [
    { text: 'Soft tissue', value: [350, 50] },
    { text: 'Lung', value: [1500, -600] },
    { text: 'Mediastinum', value: [350, 40] },
    { text: 'Bone', value: [1000, 400] },
    { text: 'Air', value: [1000, -426] },
    { text: 'Brain', value: [80, 40] },
    { text: 'Vessels', value: [600, 300] },
    { text: 'All', value: [4000, 1000] },
];

const kThresholds: readonly {
    text: string;
    value: { iso_hu: number; polarity: Polarity };
}[] = [
    { text: 'Airway, bowel, sinus', value: { iso_hu: -500, polarity: 'rising' } },
    { text: 'Skin', value: { iso_hu: -300, polarity: 'rising' } },
    { text: 'Bone', value: { iso_hu: 250, polarity: 'rising' } },
    { text: 'Vessel with contrast', value: { iso_hu: 170, polarity: 'falling' } },
];

export class Panels {
    readonly element: HTMLElement;
    private readonly controls: Control[] = [];

    constructor(
        private readonly session: Session,
        private readonly actions: Actions,
    ) {
        this.element = h(
            'aside',
            { class: 'panels', 'aria-label': 'Settings' },
            this.tool(),
            this.surface(),
            this.window(),
            this.endoscope(),
            this.material(),
            this.places(),
            this.display(),
            this.shared(),
        );
        session.store.listen(() => this.refresh());
        this.refresh();
    }

    private get state(): Readonly<State> {
        return this.session.store.state;
    }

    private refresh(): void {
        for (const control of this.controls) control.refresh();
        this.element.classList.toggle('viewing', this.state.role === 'view');
        for (const field of this.element.querySelectorAll<HTMLFieldSetElement>('fieldset.tissue'))
            field.disabled = this.state.role === 'view' || this.state.link !== 'open';
    }

    private add(control: Control): HTMLElement {
        this.controls.push(control);
        return control.element;
    }

    /// A slider for a number of the store; own: its changes can be undone.
    private number(
        key:
            | 'window'
            | 'level'
            | 'fieldOfView'
            | 'barrel'
            | 'fog'
            | 'speed'
            | 'tip'
            | 'radius'
            | 'strength'
            | 'depth',
        settings: Pick<SliderSettings, 'label' | 'unit' | 'low' | 'high' | 'step'> &
            Partial<SliderSettings>,
    ): HTMLElement {
        return this.add(
            slider({
                value: () => this.state[key],
                input: (value) => this.session.store.set({ [key]: value }),
                begin: () => this.session.history.begin(),
                end: () => this.session.history.end(settings.label.toLowerCase()),
                ...settings,
            }),
        );
    }

    private tool(): HTMLElement {
        const { session, actions } = this;
        const relax = button('Relax', () => actions.relax(), 'tissue springs back (X)');
        session.store.watch(['shared'], ({ shared }) => {
            relax.setAttribute('aria-pressed', String(shared?.relaxing ?? false));
        });
        return section(
            'Tool',
            true,
            tissue(
                this.number('radius', {
                    label: 'Size',
                    unit: 'mm',
                    low: 0.5,
                    high: 30,
                    step: 0.5,
                    curved: true,
                }),
                this.number('strength', {
                    label: 'Strength',
                    unit: '×',
                    low: 0.1,
                    high: 2,
                    step: 0.1,
                    hint: 'how far the tool goes for a motion of the pointer',
                }),
                this.number('depth', {
                    label: 'Cut depth',
                    unit: 'mm',
                    low: 1,
                    high: 60,
                    step: 1,
                    curved: true,
                }),
                this.add(
                    checkbox(
                        'tissue slides off the probe',
                        () => this.state.slide,
                        (slide) => session.store.set({ slide }),
                        'otherwise the probe takes along what it touches',
                    ),
                ),
                h(
                    'div',
                    { class: 'row' },
                    relax,
                    button(
                        'Let go',
                        () => void session.ask({ do: 'release' }),
                        'nothing is held any more (L)',
                    ),
                    button(
                        'Reset',
                        () => void session.ask({ do: 'reset' }),
                        'everything back to rest',
                    ),
                ),
            ),
            h('p', { class: 'outcome', 'aria-live': 'polite' }, this.outcome()),
        );
    }

    private outcome(): HTMLElement {
        const text = h('span');
        this.session.store.watch(['outcome'], ({ outcome }) => {
            text.textContent = outcome;
        });
        return text;
    }

    private surface(): HTMLElement {
        const { actions } = this;
        const iso = slider({
            label: 'Threshold',
            unit: 'HU',
            low: -1000,
            high: 1000,
            step: 5,
            value: () => this.state.shared?.iso_hu ?? -500,
            input: (iso_hu) => actions.iso({ iso_hu }),
        });
        return section(
            'Surface',
            true,
            tissue(
                this.add(iso),
                this.add(
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
                        () => this.state.shared?.polarity ?? 'rising',
                        (polarity) => actions.iso({ polarity }),
                    ),
                ),
                this.add(
                    presets('Presets of the threshold', kThresholds, (value) => actions.iso(value)),
                ),
            ),
            this.add(
                checkbox(
                    'as a line in the sections',
                    () => this.state.contour,
                    (contour) => this.session.store.set({ contour }),
                ),
            ),
        );
    }

    private window(): HTMLElement {
        const { store, history } = this.session;
        return section(
            'Window',
            true,
            this.number('window', {
                label: 'Window',
                unit: 'HU',
                low: 1,
                high: 4000,
                step: 1,
                curved: true,
            }),
            this.number('level', { label: 'Level', unit: 'HU', low: -1000, high: 2000, step: 1 }),
            this.add(
                presets('Presets of window and level', kWindows, ([window, level]) =>
                    history.step('window', () => store.set({ window, level })),
                ),
            ),
        );
    }

    private endoscope(): HTMLElement {
        const { store } = this.session;
        return section(
            'Endoscope',
            true,
            this.add(
                choice(
                    'At walls the tip',
                    [
                        { value: 'stop', text: 'stops' },
                        { value: 'push', text: 'pushes' },
                        { value: 'pass', text: 'passes' },
                    ],
                    () => this.state.wall,
                    (wall) => this.actions.setWall(wall),
                ),
            ),
            this.path(),
            this.number('tip', {
                label: 'Tip',
                unit: 'mm',
                low: 0.5,
                high: 8,
                step: 0.5,
                hint: 'radius',
            }),
            this.number('speed', {
                label: 'Speed',
                unit: '×',
                low: 0.1,
                high: 4,
                step: 0.1,
                curved: true,
            }),
            this.number('fieldOfView', {
                label: 'Field of view',
                unit: '°',
                low: 30,
                high: 120,
                step: 1,
            }),
            this.number('barrel', { label: 'Barrel', unit: '', low: 0, high: 0.5, step: 0.01 }),
            this.number('fog', {
                label: 'Fog',
                unit: 'mm',
                low: 0,
                high: 500,
                step: 5,
                hint: '0: none',
                curved: true,
            }),
            this.add(
                checkbox(
                    'seen from outside, cut open',
                    () => this.state.outside,
                    (on) => {
                        if (on !== store.state.outside) this.actions.toggleOutside();
                    },
                ),
            ),
        );
    }

    private path(): HTMLElement {
        const { session } = this;
        const file = h('input', {
            type: 'file',
            accept: '.json',
            hidden: true,
            'aria-label': 'path file',
            onchange: () => {
                const chosen = file.files?.[0];
                if (chosen) void this.actions.openFile(chosen);
                file.value = '';
            },
        });
        const fly = button('Fly', () => session.togglePath(), 'along the path, or pause');
        const way = slider({
            label: 'Along the path',
            unit: 'mm',
            low: 0,
            high: 1,
            step: 0.5,
            value: () => this.state.pathWay,
            input: (value) => session.goAlong(value),
            begin: () => session.history.begin(),
            end: () => session.history.end('path'),
        });
        session.store.watch(['path', 'pathFlying'], ({ path, pathFlying }) => {
            fly.disabled = !path;
            fly.setAttribute('aria-pressed', String(pathFlying));
            way.element.hidden = !path;
            way.element.querySelector('input')!.max = String(path?.length ?? 1);
        });
        const load = button(
            'Path…',
            () => file.click(),
            'load a way through the lumen (.mrk.json)',
        );
        return h(
            'div',
            { class: 'body plain' },
            h('div', { class: 'row' }, load, fly, file),
            this.add(way),
        );
    }

    private material(): HTMLElement {
        return section(
            'Material',
            false,
            tissue(
                this.materialNumber(
                    'offset',
                    'Slack',
                    '',
                    0,
                    1,
                    0.01,
                    'of the softest link, as a share of its length',
                ),
                this.materialNumber('max_movement_mm', 'Largest movement', 'mm', 0, 100, 1),
                this.materialNumber(
                    'bone_threshold_hu',
                    'Bone above',
                    'HU',
                    0,
                    2000,
                    10,
                    'does not move',
                ),
                this.materialNumber(
                    'yield',
                    'Yield',
                    '',
                    0,
                    1,
                    0.01,
                    'strain beyond it stays; 0: none',
                ),
                this.materialFlag('air_enabled', 'air is a material of its own'),
                this.materialNumber('air_threshold_hu', 'Air below', 'HU', -1000, 0, 10),
                this.materialFlag('rounded', 'rounded limits'),
            ),
        );
    }

    private materialNumber(
        key: keyof { [K in keyof Materials as Materials[K] extends number ? K : never]: 0 },
        label: string,
        unit: string,
        low: number,
        high: number,
        step: number,
        hint = '',
    ): HTMLElement {
        let wish: number | undefined; // sent once, when the slider is let go
        return this.add(
            slider({
                label,
                unit,
                low,
                high,
                step,
                hint,
                value: () => wish ?? this.state.shared?.materials[key] ?? low,
                input: (value) => {
                    wish = value;
                },
                end: () => {
                    if (wish !== undefined) void this.session.ask({ do: 'materials', [key]: wish });
                    wish = undefined;
                },
            }),
        );
    }

    private materialFlag(key: 'air_enabled' | 'rounded', label: string): HTMLElement {
        return this.add(
            checkbox(
                label,
                () => this.state.shared?.materials[key] ?? false,
                (on) => void this.session.ask({ do: 'materials', [key]: on }),
            ),
        );
    }

    private places(): HTMLElement {
        const list = h('div', { class: 'column' });
        this.session.store.watch(['volume'], ({ volume }) => {
            const start = volume?.start;
            list.replaceChildren(
                ...(start
                    ? [button('Start', () => this.session.goTo(start.eye_mm, start.look, start.up))]
                    : []),
                ...(volume?.landmarks ?? []).map((mark) =>
                    button(mark.name, () => this.session.goTo(mark.eye_mm, mark.look)),
                ),
            );
        });
        return section('Places', false, list);
    }

    private display(): HTMLElement {
        const { store } = this.session;
        return section(
            'Display',
            false,
            this.add(
                choice(
                    'Colours',
                    [
                        { value: 'system', text: "system's" },
                        { value: 'light', text: 'light' },
                        { value: 'dark', text: 'dark' },
                    ],
                    () => this.state.theme,
                    (theme) => store.set({ theme }),
                ),
            ),
            this.add(
                choice(
                    'Coordinates',
                    [
                        { value: 'LPS', text: 'LPS', hint: 'as in files' },
                        { value: 'RAS', text: 'RAS', hint: 'as 3D Slicer shows them' },
                    ],
                    () => this.state.space,
                    (space) => store.set({ space }),
                ),
            ),
            this.add(
                checkbox(
                    'finer picture when still',
                    () => this.state.fine,
                    (fine) => {
                        store.set({ fine });
                        this.session.stage.invalidate();
                    },
                ),
            ),
            this.add(
                checkbox(
                    'times (T)',
                    () => this.state.timings,
                    (timings) => store.set({ timings }),
                ),
            ),
            h(
                'div',
                { class: 'row' },
                button('Picture', () => void this.actions.snapshot(), 'save the views as PNG (P)'),
            ),
        );
    }

    private shared(): HTMLElement {
        const people = h('ul', { class: 'people' });
        const save = h('div', { class: 'column' });
        this.session.store.watch(['shared', 'client', 'features', 'link'], (state) => {
            people.replaceChildren(
                ...(state.shared?.clients ?? []).map((c) =>
                    h(
                        'li',
                        {},
                        `${c.name || `visitor ${c.client}`}`,
                        h('small', {}, c.role === 'view' ? ' views' : ' controls'),
                        c.client === state.client && h('small', {}, ' (you)'),
                    ),
                ),
            );
        });
        this.session.store.watch(['features'], ({ features }) => {
            const files = ['volume.nrrd', 'displacement.nrrd', 'transform.nrrd', 'session.pls'];
            save.replaceChildren(
                ...(features.includes('save')
                    ? files.map((name) =>
                          h(
                              'a',
                              { href: `save/${name}${this.query}`, download: name },
                              `Save ${name}`,
                          ),
                      )
                    : []),
            );
        });
        const result = h('output', { class: 'checksum' });
        return section(
            'Session',
            false,
            people,
            save,
            button(
                'Compare with the server',
                () =>
                    void this.session.compare().then((sum) => {
                        result.textContent = sum
                            ? `${sum.same ? 'equal' : 'DIFFERENT'}: ${sum.own}, ${sum.tissue}`
                            : 'no answer';
                    }),
                'checksum of all voxels, here and there',
            ),
            result,
        );
    }

    /// The token as a query, for downloads.
    query = '';
}

function section(title: string, open: boolean, ...children: (Node | false)[]): HTMLElement {
    const body = h('div', { class: 'body' }, ...children);
    return h('details', open ? { open: true } : {}, h('summary', {}, title), body);
}

/// Settings that change the tissue, or what all see: only for those who control.
const tissue = (...children: Node[]): HTMLElement =>
    h('fieldset', { class: 'tissue' }, ...children);
