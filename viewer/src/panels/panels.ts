// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The panels beside the views: every setting with its number, its unit and its preset.

import { kWatched } from '../state/company.ts';
import type { State } from '../state/state.ts';
import type { Actions } from '../tools/actions.ts';
import type { Session } from '../tools/session.ts';
import { h } from './dom.ts';
import { fluoroscopyPanel } from './panel_fluoroscopy.ts';
import { hapticsPanel } from './panel_haptics.ts';
import { labelsPanel } from './panel_labels.ts';
import { marksPanel } from './panel_marks.ts';
import { moviePanel } from './panel_movie.ts';
import { overlayPanel } from './panel_overlay.ts';
import { Parts } from './panel_parts.ts';
import { sessionPanel } from './panel_session.ts';
import { tissuePanel } from './panel_springs.ts';
import { vesselPanel } from './panel_vessel.ts';
import { slabPanel, volumePanel } from './panel_volume.ts';
import { materialPanel, surfacePanel, toolPanel } from './panels_tissue.ts';
import { displayPanel, endoscopePanel, placesPanel, windowPanel } from './panels_view.ts';

export function panels(session: Session, actions: Actions): HTMLElement {
    const parts = new Parts(session, actions);
    const element = h(
        'aside',
        { class: 'panels', 'aria-label': 'Settings' },
        vesselPanel(parts),
        toolPanel(parts),
        surfacePanel(parts),
        windowPanel(parts),
        slabPanel(parts),
        overlayPanel(parts),
        labelsPanel(parts),
        marksPanel(parts),
        endoscopePanel(parts),
        volumePanel(parts),
        fluoroscopyPanel(parts),
        tissuePanel(parts),
        materialPanel(parts),
        hapticsPanel(parts),
        moviePanel(parts),
        placesPanel(parts),
        displayPanel(parts),
        sessionPanel(parts),
    );
    const refresh = (): void => {
        parts.refresh();
        const { role, status } = parts.state.link;
        for (const field of element.querySelectorAll<HTMLFieldSetElement>('fieldset.tissue')) {
            field.disabled = role === 'view' || status !== 'open';
            field.title = parts.state.replay.isOn ? kWatched : '';
        }
    };
    // Devices, tools and time lines report often, and are no settings.
    session.store.listen((state, before) => {
        const groups = Object.keys(state) as (keyof State)[];
        const isSetting = (name: keyof State): boolean =>
            name !== 'device' && name !== 'hands' && name !== 'replay';
        if (groups.some((name) => isSetting(name) && state[name] !== before[name])) refresh();
    });
    refresh();
    return element;
}
