// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Units, steps and limits that suit a scan. The page's own defaults and limits are those for CT of
// a body, in HU and millimetres:
//
//   values    in HU they stay; other scans have limits of their own range, in about 500 steps
//   lengths   they shrink with scans whose longest side is below about 70 mm, and have as many
//             decimals more as that takes

import { fixed, nearestStep, roundTo } from '../maths/steps.ts';
import type { VolumeInfo } from '../net/protocol.ts';

/// Parts of the scan's description that are needed; null before it has arrived.
export type Kind = Pick<VolumeInfo, 'range_hu' | 'values' | 'length_scale'> | null;

/// Limits of a slider.
export interface Limits {
    readonly unit: string;
    readonly low: number;
    readonly high: number;
    readonly step: number;
}

// --- values

const kSteps = 500; // of a slider over the range
const kCtSpan = 4000; // of the values of a CT [HU]
const kCtWindow = 1500; // of a CT whose file tells none [HU]
const kCtLevel = -200;
const kWholeSpan = 200; // from this range on, steps are whole numbers
/// Largest threshold that the server takes.
export const kMaxThreshold = 65504;

/// Unit of the values: HU, or empty.
export const unitOf = (scan: Kind): string => scan?.values?.unit ?? 'HU';

export const isInHu = (scan: Kind): boolean => unitOf(scan) === 'HU';

const spanOf = ([low, high]: readonly [number, number]): number => (high > low ? high - low : 1);

/// Equivalent of 1 HU: the same share of the range as in CT.
export const valueScale = (scan: Kind): number =>
    !scan || isInHu(scan) ? 1 : spanOf(scan.range_hu) / kCtSpan;

/// Range of the values, in CT that of the Hounsfield scale.
export const spanOfValues = (scan: Kind): number => kCtSpan * valueScale(scan);

/// Step of shown values.
export function valueStep(scan: Kind): number {
    if (!scan || isInHu(scan)) return 1;
    const span = spanOf(scan.range_hu);
    const step = nearestStep(span / kSteps);
    return span >= kWholeSpan ? Math.max(step, 1) : step;
}

/// Text of a value with its unit.
export const textWithUnit = (scan: Kind, value: number): string =>
    `${fixed(value, valueStep(scan))} ${unitOf(scan)}`.trim();

/// Tests whether the file tells its own window for a CT.
export const hasOwnWindow = ({ values }: VolumeInfo): boolean =>
    values !== undefined && (values.window !== kCtWindow || values.level !== kCtLevel);

/// Window and level that the server suggests: the file's own, or some that suit the values.
export function windowOf(scan: VolumeInfo): { window: number; level: number } {
    if (!scan.values) return { window: kCtWindow, level: kCtLevel };
    const step = valueStep(scan);
    const { window, level } = scan.values;
    return { window: Math.max(roundTo(window, step), step), level: roundTo(level, step) };
}

/// Limits of a value. @param ct  those for values in HU
export function valueLimits(scan: Kind, ct: Limits): Limits {
    if (!scan || isInHu(scan)) return ct;
    const step = valueStep(scan);
    const [low, high] = scan.range_hu;
    return {
        unit: unitOf(scan),
        low: roundTo(Math.floor(low / step) * step, step),
        high: roundTo(Math.max(Math.ceil(high / step), Math.floor(low / step) + 1) * step, step),
        step,
    };
}

/// Reach of the level by gestures: half a range beyond both ends.
export function levelReach(scan: Kind): { low: number; high: number } {
    if (!scan || isInHu(scan)) return { low: -2000, high: 4000 };
    const [low, high] = scan.range_hu;
    const beyond = 0.5 * spanOf(scan.range_hu);
    return { low: low - beyond, high: high + beyond };
}

/// Limits of the width of a window. @param ct  those for values in HU
export function widthLimits(scan: Kind, ct: Limits): Limits {
    if (!scan || isInHu(scan)) return ct;
    const { unit, low, high, step } = valueLimits(scan, ct);
    return { unit, low: step, high: roundTo(high - low, step), step };
}

// --- lengths

const exactScale = (scan: Kind): number => scan?.length_scale ?? 1;

/// Factor of lengths that suit a body: 1, or 1, 2 or 5 times a power of ten below it.
export const scaleOf = (scan: Kind): number => nearestStep(exactScale(scan));

/// Round length that suits the scan, for limits and steps. @param mm  in a body
export const roundLength = (scan: Kind, mm: number): number =>
    Number((scaleOf(scan) * mm).toPrecision(6));

/// Length that suits the scan: a multiple of a step, at least one. @param mm, step  in a body
export function lengthFor(scan: Kind, mm: number, step: number): number {
    const own = roundLength(scan, step);
    return Math.max(roundTo(exactScale(scan) * mm, own), own);
}

/// Text of a length without its unit. @param step  in a body [mm]
export const lengthText = (scan: Kind, mm: number, step = 0.1): string =>
    fixed(mm, roundLength(scan, step));

/// Text of an area without its unit. @param step  in a body [mm²]
export const areaText = (scan: Kind, mm2: number, step = 0.1): string =>
    fixed(mm2, step * scaleOf(scan) ** 2);

/// Text of a volume with its unit.
export const volumeText = (mm3: number): string =>
    mm3 >= 100 ? `${Number((mm3 / 1000).toPrecision(3))} ml` : `${Number(mm3.toPrecision(3))} mm³`;

/// Limits of a length. @param body  those for a body
export const lengthLimits = (scan: Kind, { unit, low, high, step }: Limits): Limits => ({
    unit,
    low: roundLength(scan, low),
    high: roundLength(scan, high),
    step: roundLength(scan, step),
});

const kSlowPace = 0.3; // a hand no longer feels what it does

/// Simulated over real time, in words where it is slow. @param pace  0: unknown
export function paceText(pace: number): string {
    if (!(pace > 0)) return '–';
    if (pace < kSlowPace) return `slow, 1/${Math.round(1 / pace)} of real time`;
    return `${pace.toPrecision(2)} × real time`;
}
