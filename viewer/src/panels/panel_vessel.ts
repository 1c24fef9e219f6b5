// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panel of the catheter: drive and forces. Shown only if the scene has a vessel.

import type { VesselState } from '../net/protocol.ts';
import { offersVessel } from '../state/state.ts';
import { paceText } from '../state/units.ts';
import { kMaxBend, kMaxInsert } from '../tools/catheter_hand.ts';
import { button, checkbox, h, slider } from './dom.ts';
import { type Parts, section, tissue } from './panel_parts.ts';

/// Numbers of the catheter as text, by name.
export function numbersOf(vessel: VesselState): Record<string, string> {
    const began = vessel.time_s > 0;
    const beyond = vessel.depth_mm > 0;
    const far = vessel.depth_mm <= -1; // the server's search ends there
    const depth = far ? '> 1' : Math.abs(vessel.depth_mm).toFixed(2);
    return {
        inserted: `${vessel.inserted_mm.toFixed(1)} mm`,
        'force on the hand': `${vessel.force_n.toFixed(3)} N`,
        'wall moved': `${vessel.wall_moved_mm.toFixed(2)} mm`,
        'deepest point': began ? `${depth} mm ${beyond ? 'outside' : 'inside'}` : '–',
        'sub-steps': vessel.sub_steps > 0 ? `${vessel.sub_steps} in a step` : '–',
        pace: paceText(vessel.pace),
    };
}

/// A warning without its numbers, to tell it once while they change.
function kindOf(warning: string): string {
    return warning.replace(/[\d.]+/g, '');
}

export function vesselPanel(parts: Parts): HTMLElement {
    const { session } = parts;
    const spots = new Map<string, HTMLElement>();
    const list = h('dl', { class: 'numbers' });
    const failure = h('small', { class: 'quiet', role: 'alert' });
    const warnings = h('ul', { class: 'warnings', role: 'alert' });
    let told = '';
    const warn = (lines: readonly string[]): void => {
        const kinds = lines.map(kindOf).join('\n');
        if (kinds !== told && lines.length > 0) session.warn(lines.join('; '));
        told = kinds;
        warnings.replaceChildren(...lines.map((line) => h('li', {}, line)));
    };
    const show = (vessel: VesselState | undefined): void => {
        for (const [name, value] of Object.entries(vessel ? numbersOf(vessel) : {})) {
            let spot = spots.get(name);
            if (!spot) {
                spot = h('dd', { 'data-name': name });
                spots.set(name, spot);
                list.append(h('div', {}, h('dt', {}, name), spot));
            }
            spot.textContent = value;
        }
        failure.textContent = vessel?.failure ?? '';
        warn(vessel?.warnings ?? []);
    };
    const back = button('Back to the vessel', () => {
        void session.ask({ do: 'tissue', model: 'vessel' });
    });
    const driving = tissue(...handControls(parts));
    const ride = parts.add(
        checkbox(
            'endoscope rides on the tip (I)',
            () => parts.state.view.onTip,
            () => session.ride.toggle(),
            'seen from behind the tip; own flights and looks end it',
        ),
    );
    const element = section('Catheter', true, list, warnings, failure, ride, driving, back);
    session.store.watch(
        ({ shared }) => [shared],
        (shared) => {
            element.hidden = !offersVessel(shared);
            const there = shared?.vessel !== undefined;
            list.hidden = ride.hidden = driving.hidden = !there;
            back.hidden = there;
            show(shared?.vessel);
        },
    );
    return element;
}

/// Creates the sliders: speeds return to 0 when a slider is released; bends stay.
function handControls(parts: Parts): HTMLElement[] {
    const hand = parts.session.catheter;
    const rate = (key: 'insert' | 'rotate', label: string, most: number) =>
        parts.add(
            slider({
                label,
                unit: '',
                low: -most,
                high: most,
                step: 1,
                hint: 'moves while the slider is held; or use the arrow keys',
                value: () => hand[key],
                input: (value) => {
                    hand[key] = Math.min(Math.max(value, -most), most);
                },
                end: () => {
                    hand[key] = 0;
                    parts.refresh();
                },
            }),
        );
    const bend = (which: 0 | 1, label: string) =>
        parts.add(
            slider({
                label,
                unit: '°',
                low: -kMaxBend,
                high: kMaxBend,
                step: 1,
                value: () => hand.bend[which],
                input: (value) => hand.setBend(which, value),
            }),
        );
    return [
        rate('insert', 'Insert, mm/s', kMaxInsert),
        rate('rotate', 'Rotate, °/s', 360),
        bend(0, 'Bend, first axis'),
        bend(1, 'Bend, second axis'),
        parts.add(
            slider({
                label: 'Speed of keys, mm/s',
                unit: '',
                low: 1,
                high: kMaxInsert,
                step: 1,
                value: () => hand.speed,
                input: (value) => {
                    hand.speed = Math.min(Math.max(value, 1), kMaxInsert);
                },
            }),
        ),
        h(
            'div',
            { class: 'row' },
            button('Stop', () => hand.stop(), 'stops insertion and rotation (Space)'),
            button('Straighten', () => hand.straighten(), 'straightens the tip'),
            button('Reset', () => void parts.session.ask({ do: 'reset' }), 'back to the start'),
        ),
    ];
}
