// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Window and level from a scan's own values.

import { floatOfHalf } from './half.ts';
import { roundTo } from './steps.ts';
import type { VolumeData } from './volume.ts';

const kSamples = 20_000;
const kTail = 0.01; // share of the values beyond each end of the window

/// Window that holds all but the darkest and brightest percent of the values. The commonest of the
/// darkest values, padding around the patient, is left out. @param valueStep  of the result
export function autoWindow(
    { halves }: VolumeData,
    valueStep = 1,
): { window: number; level: number } {
    const step = Math.max(Math.floor(halves.length / kSamples), 1);
    const values: number[] = [];
    for (let i = step >> 1; i < halves.length; i += step) values.push(floatOfHalf[halves[i]!]!);
    values.sort((a, b) => a - b);
    const above = values.filter((value) => value > values[0]!);
    const kept = above.length > 0.1 * values.length ? above : values;
    const at = (share: number): number => kept[Math.floor(share * (kept.length - 1))]!;
    const [low, high] = [at(kTail), at(1 - kTail)];
    return {
        window: Math.max(roundTo(high - low, valueStep), valueStep),
        level: roundTo((low + high) / 2, valueStep),
    };
}
