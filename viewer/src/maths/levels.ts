// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Characteristic values of a scan, from its histogram.

import { floatOfHalf } from './half.ts';

export interface Levels {
    readonly low: number; ///< 0.5th percentile
    readonly threshold: number; ///< between background and tissue, after [Otsu1979]
    readonly bright: number; ///< 90th percentile of the values above the threshold
    readonly high: number; ///< 99.5th percentile of these
}

const kBins = 256;
const kMaxSamples = 1 << 20;

/// Values of voxels in half floats; of about a million of them in larger scans.
export function samplesOf(halves: Uint16Array): Float32Array {
    const stride = Math.max(Math.floor(halves.length / kMaxSamples), 1) | 1;
    const values = new Float32Array(Math.ceil(halves.length / stride));
    for (let i = 0; i < values.length; ++i) values[i] = floatOfHalf[halves[i * stride]!]!;
    return values;
}

/// Histogram of values; those beyond its ends are in the first and the last bin.
export function countsOf(
    values: Float32Array,
    low: number,
    high: number,
    bins: number,
): Float64Array {
    const width = (high - low) / bins;
    const counts = new Float64Array(bins);
    for (const v of values)
        ++counts[Math.min(Math.max(Math.floor((v - low) / width), 0), bins - 1)]!;
    return counts;
}

/// Levels of voxels in half floats.
export function levelsOf(halves: Uint16Array): Levels {
    const values = samplesOf(halves).sort();
    const at = (share: number, from = 0): number =>
        values[Math.min(from + Math.floor(share * (values.length - from)), values.length - 1)]!;
    const low = at(0.005);
    const threshold = otsu(values, low, at(0.995));
    let from = values.findIndex((v) => v > threshold);
    if (from < 0) from = values.length - 1;
    return { low, threshold, bright: at(0.9, from), high: at(0.995, from) };
}

/// Threshold with the largest variance between the two classes [Otsu1979].
function otsu(values: Float32Array, low: number, high: number): number {
    const width = (high - low) / kBins;
    if (!(width > 0)) return low;
    const counts = countsOf(values, low, high, kBins);
    let total = 0;
    counts.forEach((n, i) => (total += n * i));
    let [below, sum, best, found] = [0, 0, -1, 0];
    for (let i = 0; i + 1 < kBins; ++i) {
        below += counts[i]!;
        sum += counts[i]! * i;
        const above = values.length - below;
        if (!below || !above) continue;
        const gap = sum / below - (total - sum) / above;
        const variance = below * above * gap * gap;
        if (variance > best) [best, found] = [variance, i];
    }
    return low + (found + 1) * width;
}
