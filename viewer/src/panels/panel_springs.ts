// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panel of the tissue model: ChainMail, springs with the depth that forces reach, the elastic scan,
// or organs.

import { cssOf } from '../maths/colour_map.ts';
import type { Vec3 } from '../maths/vec.ts';
import type { TissueChoice, TissueState } from '../net/protocol.ts';
import { springRows } from '../net/settings.ts';
import { haveBodies, isOfBodies, lookOf } from '../state/labels.ts';
import { lengthFor, paceText } from '../state/units.ts';
import { button, checkbox, choice, h } from './dom.ts';
import { elasticControls, elasticText } from './panel_elastic.ts';
import { type Parts, section, tissue } from './panel_parts.ts';

const kCell = 8; // in a body [mm]
const kNodes = 20; ///< of the control lattice, along each axis
const kYoung = 15; ///< [kPa]

/// Summary of springs: number of nodes, depth with the line that limits it, and update rate.
export function springsText(state: TissueState | undefined): string {
    if (state?.model !== 'springs') return '';
    const nodes = (state.nodes as Vec3).join(' × ');
    const hz = state.update_hz!;
    const rate = hz > 0 ? `${hz.toFixed(0)} updates/s` : 'not moved yet';
    const line = state.line_mb_s ? ` (line takes ${state.line_mb_s} MB/s)` : '';
    const layers = state.depth === 1 ? '1 layer' : `${state.depth!} layers`;
    return `${nodes} nodes, ${state.active_nodes!} within ${layers}${line}, ${rate}`;
}

/// Lines about organs: each body, the number of held nodes, and the pace.
export function organLines(state: TissueState | undefined): string[] {
    if (state?.model !== 'own' || !state.bodies) return [];
    const { particles = 0, fixed_particles = 0, edge_mm = 0, time_step_ms = 0 } = state;
    const pace = ((state.update_hz ?? 0) * time_step_ms) / 1000;
    return [
        ...state.bodies.split('\n'),
        `${particles} nodes, ${fixed_particles} of them held; ` +
            `edges of ${edge_mm.toPrecision(2)} mm`,
        pace > 0 ? `pace of the last motion: ${paceText(pace)}` : 'not moved yet',
    ];
}

export function tissuePanel(parts: Parts): HTMLElement {
    const { session } = parts;
    let cell = kCell; // edge of the next lattice's cells [mm]
    // Moduli of the next lattice; unless chosen here, the scan's materials determine them.
    let young: number | undefined; // [kPa]
    let poisson: number | undefined;
    let shown: TissueState['model'] | undefined;
    let wish: number | undefined; // sent once, when the slider is let go
    const now = (): TissueState | undefined => parts.state.shared?.tissue;
    const elastic = elasticControls(parts, (settings) => make({ model: 'elastic', ...settings }));
    const make = (tissue: TissueChoice): void => {
        const had = (parts.state.shared?.undo.steps ?? 0) > 0;
        void session.ask({ do: 'tissue', ...tissue }).then((done) => {
            if (done && had) session.say('the tissue is at rest again; earlier steps are gone');
        });
    };
    const choose = (model: TissueState['model']): void =>
        make(
            model === 'springs'
                ? {
                      model,
                      centre: parts.state.sections.cursor,
                      nodes: kNodes,
                      cell_mm: cell,
                      ...(young !== undefined && { young_modulus_pa: 1000 * young }),
                      ...(poisson !== undefined && { poisson_ratio: poisson }),
                  }
                : { model, ...(model === 'elastic' && elastic.settings()) },
        );
    const depth = parts.slider({
        label: 'Depth of forces, layers',
        unit: '',
        low: 0,
        high: 20,
        step: 1,
        hint: 'nodes beyond do not move; fewer layers are faster',
        value: () => wish ?? now()?.depth ?? 10,
        input: (value) => {
            wish = Math.round(value);
        },
        end: () => {
            if (wish !== undefined) void session.ask({ do: 'depth', layers: wish });
            wish = undefined;
        },
    });
    const byTime = parts.add(
        checkbox(
            'automatic depth',
            () => now()?.depth_by_time ?? false,
            (on) => void session.ask({ do: 'depth', by_time: on }),
            'the server lowers or raises the depth so that motion keeps its pace, and slow lines ' +
                'their updates',
        ),
    );
    const find = button(
        'Find depth',
        () => void session.findDepth(),
        'for the tissue that is held now: the least depth that changes little (Shift+X)',
    );
    const text = h('small', { class: 'quiet springs' });
    const lines = h('ul', { class: 'quiet organs' });
    const trouble = h('small', { class: 'quiet', role: 'alert' });
    const cells = parts.slider({
        label: 'Cell',
        unit: 'mm',
        low: 2,
        high: 30,
        step: 0.5,
        hint: 'for the next choice of springs',
        value: () => cell,
        input: (value) => {
            cell = value;
        },
    });
    const stiffness = parts.slider({
        label: "Young's modulus",
        unit: 'kPa',
        low: 0.5,
        high: 100,
        step: 0.5,
        curved: true,
        hint: 'of unlabelled tissue, for the next choice of springs',
        value: () => young ?? (now()?.young_modulus_pa ?? 1000 * kYoung) / 1000,
        input: (value) => {
            young = value;
        },
    });
    const ratio = parts.slider({
        label: "Poisson's ratio",
        unit: '',
        low: springRows.poisson_ratio.low!,
        high: 0.49,
        step: 0.01,
        hint: 'for the next choice of springs; above 0.25 cells resist changes of volume',
        value: () => poisson ?? now()?.poisson_ratio ?? springRows.poisson_ratio.low!,
        input: (value) => {
            poisson = value;
        },
    });
    const model = parts.add(
        choice<TissueState['model']>(
            'Model',
            [
                {
                    value: 'own',
                    text: 'organs',
                    hint: 'the tetrahedra that the scene was opened with; clears the history',
                },
                {
                    value: 'chainmail',
                    text: 'ChainMail',
                    hint: 'one element per voxel, with limits of its links',
                },
                {
                    value: 'elastic',
                    text: 'elastic',
                    hint: 'equilibrium of the voxels under their moduli; clears the history',
                },
                {
                    value: 'springs',
                    text: 'springs',
                    hint: `${kNodes}³ nodes around the crosshair; clears the history`,
                },
            ],
            () => now()?.model ?? 'chainmail',
            choose,
        ),
    );
    const own = model.querySelector('[value=own]')!.parentElement!;
    const coloured = parts.add(
        checkbox(
            'bodies in colours',
            () => parts.state.labels.coloured,
            (on) => session.store.set({ labels: { coloured: on } }),
            'tints each body in all views',
        ),
    );
    const contact = parts.add(
        checkbox(
            'show where bodies touch',
            () => parts.state.labels.contact,
            (on) => session.store.set({ labels: { contact: on } }),
            'stripes on both sides, which part where bodies slide on each other',
        ),
    );
    const element = section(
        'Tissue',
        false,
        tissue(model, elastic.element, cells, stiffness, ratio, depth, byTime, find),
        coloured,
        contact,
        lines,
        trouble,
        text,
    );
    /// Lists the bodies, each with its colour in the views.
    const listOrgans = (): void => {
        const { labels } = parts.state;
        const bodies = labels.list.filter(({ body }) => body > 0);
        lines.replaceChildren(
            ...organLines(now()).map((line) => {
                const label = bodies.find(({ name }) => name && line.startsWith(`${name}: `));
                if (!label || !lookOf(labels, label).shown) return h('li', {}, line);
                const swatch = h('i', { 'aria-hidden': 'true' });
                swatch.style.background = cssOf(label.colour);
                return h('li', {}, swatch, line);
            }),
        );
        coloured.hidden = !isOfBodies(labels);
        contact.hidden = now()?.model !== 'own' || !haveBodies(labels);
    };
    session.store.watch(
        ({ labels: { list, looks, coloured } }) => [list, looks, coloured],
        () => listOrgans(),
    );
    session.store.watch(
        ({ scan }) => [scan.volume],
        (volume) => {
            cell = lengthFor(volume, kCell, 0.5);
            young = poisson = undefined;
        },
    );
    session.store.watch(
        ({ shared, link }) => [shared, link],
        (shared, link) => {
            element.hidden = link.status === 'open' && !link.features.includes('tissue');
            const state = shared?.tissue;
            depth.hidden = byTime.hidden = find.hidden = state?.model !== 'springs';
            cells.hidden =
                stiffness.hidden =
                ratio.hidden =
                    state?.model === 'own' || state?.model === 'elastic';
            own.hidden = !state?.has_own;
            text.textContent = springsText(state) || elasticText(state);
            const stopped = state?.trouble ? `motion stopped: ${state.trouble}` : '';
            if (stopped && stopped !== trouble.textContent) session.warn(stopped);
            trouble.textContent = stopped;
            listOrgans();
            if (state?.model === 'own' && shown !== 'own') element.setAttribute('open', '');
            shown = state?.model;
        },
    );
    return element;
}
