// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The overlays that there are: what their numbers mean, how they are coloured and written.

import { kDiverging, kRising } from '../maths/colour_map.ts';
import type { Vec3 } from '../maths/vec.ts';
import type { OverlayKind } from '../net/protocol.ts';
import type { State } from './store.ts';

export type ShownKind = Exclude<OverlayKind, 'none'>;

interface Kind {
    readonly format: number; ///< of its boxes in the protocol
    readonly title: string;
    readonly hint: string;
    readonly rest: number; ///< where nothing is deformed
    readonly colours: readonly Vec3[];
    /// The key of what the range reaches to, from rest on, where it is fixed.
    readonly reachKey: 'overlayMm' | 'overlayGrowth';
    readonly leastReach: number;
    readonly mostReach: number; ///< of one that follows the values
    readonly text: (value: number) => string;
    /// At the ends of the legend.
    readonly label: (value: number) => string;
}

const short = (value: number): string => String(Number(value.toFixed(3)));

export const kKinds: Record<ShownKind, Kind> = {
    displacement: {
        format: 2,
        title: 'Displacement [mm]',
        hint: 'how far the tissue that is shown here has moved',
        rest: 0,
        colours: kRising,
        reachKey: 'overlayMm',
        leastReach: 0.5,
        mostReach: 500,
        text: (value) => `moved ${value.toFixed(2)} mm`,
        label: short,
    },
    jacobian: {
        format: 3,
        title: 'Volume change [×]',
        hint: 'Jacobian determinant: how many times as large it became; below 0: inside out',
        rest: 1,
        colours: kDiverging,
        reachKey: 'overlayGrowth',
        leastReach: 0.05,
        mostReach: 1,
        text: (value) => `volume × ${value.toFixed(3)}`,
        label: (value) => `×${short(value)}`,
    },
};

export interface Range {
    readonly low: number;
    readonly high: number;
}

/// The next of 1, 2 and 5 times a power of ten.
export function roundReach(value: number): number {
    const power = 10 ** Math.floor(Math.log10(value));
    const leading = [1, 2, 5, 10].find((n) => n * power >= value * (1 - 1e-9))!;
    return Number((leading * power).toPrecision(1));
}

/// Which values get the colours at the ends of the map.
export function rangeOf(state: Readonly<State>): Range {
    if (state.overlay === 'none') return { low: 0, high: 1 };
    const { rest, reachKey, leastReach, mostReach } = kKinds[state.overlay];
    const reach = state.overlayAuto
        ? roundReach(Math.min(Math.max(state.overlayExtreme, leastReach), mostReach))
        : state[reachKey];
    return { low: rest === 0 ? 0 : rest - reach, high: rest + reach };
}
