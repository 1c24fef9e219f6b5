// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Opacity transfer functions of the volume rendering: extinction [1/mm] and colour of each value,
// linear between points and constant beyond them. With two points it is the ramp of the C++
// renderer (src/view/render/blend.h): no extinction and the dim colour at the window's lower end,
// the full extinction and the bright colour at its upper end.
//
// Presets for CT are in HU. For other scans, whose values have no unit, they follow the histogram.

import type { Levels } from './levels.ts';
import type { Vec3 } from './vec.ts';

export interface TransferPoint {
    readonly value: number; ///< [HU]
    readonly perMm: number; ///< extinction [1/mm]
    readonly colour: Vec3; ///< sRGB, 0…255
}

/// Points by ascending value; 1 … kMaxPoints of them.
export type Transfer = readonly TransferPoint[];

export const kMaxPoints = 8; ///< as in shaders/blend.frag.glsl
const kSteepShare = 0.1; // as in src/view/render/blend.cpp

/// Zero at low, then rising to perMm at high.
export const rampOf = (
    low: number,
    high: number,
    perMm: number,
    dim: Vec3 = [150, 60, 40],
    bright: Vec3 = [255, 250, 240],
): Transfer => [
    { value: low, perMm: 0, colour: dim },
    { value: high, perMm, colour: bright },
];

/// Multiplies the extinction and moves the points along the values [HU].
export const adjusted = (transfer: Transfer, opacity: number, shift: number): Transfer =>
    transfer.map(({ value, perMm, colour }) => ({
        value: value + shift,
        perMm: perMm * opacity,
        colour,
    }));

/// Change of the values per mm from which on a sample is shaded like a surface.
export const steepOf = (transfer: Transfer): number =>
    Math.max(kSteepShare * (transfer[transfer.length - 1]!.value - transfer[0]!.value), 1e-6);

/// Linear light of an sRGB component, 0…255.
export const linearOf = (s: number): number =>
    s <= 0.04045 * 255 ? s / 255 / 12.92 : ((s / 255 + 0.055) / 1.055) ** 2.4;

/// Extinction [1/mm] and linear colour of a value.
export function transferAt(transfer: Transfer, value: number): { perMm: number; light: Vec3 } {
    const lightOf = ({ colour }: TransferPoint): Vec3 => colour.map(linearOf) as unknown as Vec3;
    let { perMm } = transfer[0]!;
    let light = lightOf(transfer[0]!);
    for (let i = 1; i < transfer.length; ++i) {
        const [before, point] = [transfer[i - 1]!, transfer[i]!];
        const width = Math.max(point.value - before.value, 1e-6);
        const share = Math.min(Math.max((value - before.value) / width, 0), 1);
        perMm += share * (point.perMm - perMm);
        const own = lightOf(point);
        light = light.map((c, a) => c + share * (own[a]! - c)) as unknown as Vec3;
    }
    return { perMm, light };
}

/// Intervals of values without extinction, from below upwards: bricks within one are skipped.
export function emptyRanges(transfer: Transfer): [number, number][] {
    const ranges: [number, number][] = [];
    let begin = transfer[0]!.perMm > 0 ? undefined : -Infinity;
    transfer.forEach(({ value, perMm }, i) => {
        const next = transfer[i + 1];
        const continues = !perMm && !(next?.perMm ?? 0);
        if (begin !== undefined && !continues) {
            ranges.push([begin, value]);
            begin = undefined;
        } else if (begin === undefined && continues) begin = value;
    });
    if (begin !== undefined) ranges.push([begin, Infinity]);
    return ranges.filter(([low, high]) => low < high);
}

// --- presets

export interface TransferPreset {
    readonly name: string;
    readonly hint: string;
    /// @param levels  of the scan; called by presets that follow it
    readonly transferOf: (levels: () => Levels) => Transfer;
}

/// The default of `pliant render --view blended`.
export const kMuscle = rampOf(-100, 400, 0.25);

const fixed = (name: string, hint: string, transfer: Transfer): TransferPreset => ({
    name,
    hint,
    transferOf: () => transfer,
});
const points = (...rows: readonly (readonly [number, number, Vec3])[]): Transfer =>
    rows.map(([value, perMm, colour]) => ({ value, perMm, colour }));

export const kCtPresets: readonly TransferPreset[] = [
    fixed('muscle', 'soft tissue and bones, −100 to 400 HU', kMuscle),
    fixed(
        'skin',
        'the outer surface, −650 to −50 HU',
        // One colour: the value at which rays end differs from voxel to voxel, in rings.
        rampOf(-650, -50, 0.8, [232, 188, 160], [232, 188, 160]),
    ),
    fixed(
        'bones',
        'bones alone, 180 to 500 HU',
        rampOf(180, 500, 0.5, [160, 104, 70], [255, 250, 240]),
    ),
    fixed(
        'lung',
        'lungs and airways as glass, −950 to −420 HU',
        points(
            [-950, 0, [96, 150, 214]],
            [-880, 0.005, [96, 150, 214]],
            [-760, 0.014, [150, 200, 235]],
            [-600, 0.045, [244, 206, 186]],
            [-420, 0, [235, 170, 150]],
        ),
    ),
    fixed(
        'vessels',
        'contrast medium red, 130 to 380 HU; bones pale',
        points(
            [130, 0, [110, 16, 16]],
            [260, 0.25, [214, 44, 34]],
            [380, 0.35, [236, 120, 84]],
            [700, 0.5, [255, 246, 226]],
        ),
    ),
];

const kLeastRamp = 1e-3; // of the values of a scan

/// Value between the low end and the threshold of a scan.
const between = ({ low, threshold }: Levels, share: number): number =>
    low + share * (threshold - low);

export const kLevelPresets: readonly TransferPreset[] = [
    {
        name: 'surface',
        hint: 'everything above the background of this scan',
        transferOf: (levels) =>
            rampOf(
                between(levels(), 0.5),
                between(levels(), 1.3),
                0.6,
                [150, 120, 105],
                [240, 222, 206],
            ),
    },
    {
        name: 'bright',
        hint: 'the brightest tenth of the tissue in this scan',
        transferOf: (levels) => {
            const { low, bright, high } = levels();
            const least = kLeastRamp * Math.max(high - low, 1e-3);
            return rampOf(bright, Math.max(high, bright + least), 0.4);
        },
    },
    {
        name: 'dark',
        hint: 'dark tissue and cavities of this scan as glass',
        transferOf: (levels) =>
            points(
                [between(levels(), 0.25), 0, [90, 140, 200]],
                [between(levels(), 0.5), 0.04, [120, 170, 215]],
                [between(levels(), 0.85), 0.04, [225, 200, 180]],
                [between(levels(), 1.1), 0, [225, 200, 180]],
            ),
    },
];
