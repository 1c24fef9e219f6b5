// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What a reload of the page must not lose: camera, window, tool. Kept in the tab's own storage, and
// only taken up for the same scan.

import type { Memory } from '../net/connection.ts';
import type { State, Store } from './store.ts';

const kKey = 'pliant.view';
const kKept = [
    'camera',
    'cursor',
    'style',
    'styleChosen',
    'lining',
    'fieldStop',
    'outside',
    'fluoroscopy',
    'fluoroContrast',
    'fluoroExposure',
    'fluoroField',
    'fluoroNoise',
    'orbit',
    'fieldOfView',
    'barrel',
    'fog',
    'speed',
    'wall',
    'tip',
    'sections',
    'window',
    'level',
    'contour',
    'overlay',
    'overlayOpacity',
    'overlayAuto',
    'overlayMm',
    'overlayGrowth',
    'tool',
    'radius',
    'strength',
    'slide',
    'depth',
    'maximised',
    'space',
    'timings',
    'keyframes',
] as const;

/// Which scan a view belongs to.
const scanOf = ({ volume }: State): string =>
    volume ? [volume.name, ...volume.size, ...volume.origin_mm].join(' ') : '';

export function keepView(store: Store, memory: Memory): void {
    const kept = Object.fromEntries(kKept.map((key) => [key, store.state[key]]));
    if (store.state.volume)
        memory.setItem(kKey, JSON.stringify({ scan: scanOf(store.state), kept }));
}

/// @returns whether there was a view of this scan
export function takeUpView(store: Store, memory: Memory): boolean {
    const text = memory.getItem(kKey);
    if (!text) return false;
    const { scan, kept } = JSON.parse(text) as { scan: string; kept: Partial<State> };
    if (scan !== scanOf(store.state)) return false;
    store.set(kept);
    return true;
}
