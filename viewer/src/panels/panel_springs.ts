// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panel of the tissue model: ChainMail, or springs with the depth that forces reach.

import type { TissueState } from '../net/protocol.ts';
import { lengthFor } from '../state/units.ts';
import { choice, h } from './dom.ts';
import { type Parts, section, tissue } from './panel_parts.ts';

const kCell = 8; // in a body [mm]
const kNodes = 20; ///< of the control lattice, along each axis

/// Summary of springs: number of nodes and update rate.
export function springsText(state: TissueState | undefined): string {
    if (state?.model !== 'springs') return '';
    const nodes = state.nodes!.join(' × ');
    const hz = state.update_hz!;
    const rate = hz > 0 ? `${hz.toFixed(0)} updates/s` : 'not moved yet';
    return `${nodes} nodes, ${state.active_nodes!} within ${state.depth!} layers, ${rate}`;
}

export function tissuePanel(parts: Parts): HTMLElement {
    const { session } = parts;
    let cell = kCell; // edge of the next lattice's cells [mm]
    let wish: number | undefined; // sent once, when the slider is let go
    const now = (): TissueState | undefined => parts.state.shared?.tissue;
    const choose = (model: TissueState['model']): void => {
        const { cursor } = parts.state.sections;
        const had = (parts.state.shared?.undo.steps ?? 0) > 0;
        void session
            .ask(
                model === 'springs'
                    ? { do: 'tissue', model, centre: cursor, nodes: kNodes, cell_mm: cell }
                    : { do: 'tissue', model },
            )
            .then((done) => {
                if (done && had) session.say('the tissue is at rest again; earlier steps are gone');
            });
    };
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
    const text = h('small', { class: 'quiet springs' });
    const element = section(
        'Tissue',
        false,
        tissue(
            parts.add(
                choice<TissueState['model']>(
                    'Model',
                    [
                        {
                            value: 'chainmail',
                            text: 'ChainMail',
                            hint: 'one element per voxel, with limits of its links',
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
            ),
            parts.slider({
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
            }),
            depth,
        ),
        text,
    );
    session.store.watch(
        ({ scan }) => [scan.volume],
        (volume) => {
            cell = lengthFor(volume, kCell, 0.5);
        },
    );
    session.store.watch(
        ({ shared, link }) => [shared, link],
        (shared, link) => {
            element.hidden = link.status === 'open' && !link.features.includes('tissue');
            depth.hidden = shared?.tissue?.model !== 'springs';
            text.textContent = springsText(shared?.tissue);
        },
    );
    return element;
}
