// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Kinds of overlay: the meaning of their values, their colours and texts.

import { kDiverging, kRising } from '../maths/colour_map.ts';
import type { Vec3 } from '../maths/vec.ts';
import type { OverlayKind } from '../net/protocol.ts';
import type { State } from './state.ts';
import { type Kind as ScanKind, lengthText, roundLength } from './units.ts';

export type ShownKind = Exclude<OverlayKind, 'none'>;

interface Kind {
    readonly format: number; ///< of its boxes in the protocol
    readonly title: string;
    readonly hint: string;
    readonly rest: number; ///< value of undeformed tissue
    readonly colours: readonly Vec3[];
    readonly reachKey: 'mm' | 'growth'; ///< setting of a fixed range's reach, from rest on
    readonly minReach: number; ///< of a range that follows the values; lengths: in a body
    readonly maxReach: number;
    readonly text: (value: number, scan: ScanKind) => string;
    readonly label: (value: number) => string; ///< at the ends of the legend
}

const short = (value: number): string =>
    String(Number(Math.abs(value) < 0.1 ? value.toPrecision(3) : value.toFixed(3)));

export const kKinds: Record<ShownKind, Kind> = {
    displacement: {
        format: 2,
        title: 'Displacement [mm]',
        hint: 'distance that the tissue shown here has moved',
        rest: 0,
        colours: kRising,
        reachKey: 'mm',
        minReach: 0.5,
        maxReach: 500,
        text: (value, scan) => `moved ${lengthText(scan, value, 0.01)} mm`,
        label: short,
    },
    jacobian: {
        format: 3,
        title: 'Volume change [×]',
        hint: 'Jacobian determinant: volume over volume at rest; below 0: inside out',
        rest: 1,
        colours: kDiverging,
        reachKey: 'growth',
        minReach: 0.05,
        maxReach: 1,
        text: (value) => `volume × ${value.toFixed(3)}`,
        label: (value) => `×${short(value)}`,
    },
};

export interface Range {
    readonly low: number;
    readonly high: number;
}

/// Rounds up to 1, 2 or 5 times a power of ten.
export function roundReach(value: number): number {
    const power = 10 ** Math.floor(Math.log10(value));
    const leading = [1, 2, 5, 10].find((n) => n * power >= value * (1 - 1e-9))!;
    return Number((leading * power).toPrecision(1));
}

/// Values at the two ends of the colour map.
export function rangeOf({ overlay, scan }: Pick<State, 'overlay' | 'scan'>): Range {
    if (overlay.kind === 'none') return { low: 0, high: 1 };
    const { rest, reachKey, minReach, maxReach } = kKinds[overlay.kind];
    const least = reachKey === 'mm' ? roundLength(scan.volume, minReach) : minReach;
    const reach = overlay.auto
        ? roundReach(Math.min(Math.max(scan.extreme, least), maxReach))
        : overlay[reachKey];
    return { low: rest === 0 ? 0 : rest - reach, high: rest + reach };
}
