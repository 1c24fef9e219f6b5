// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Colour maps, made in Oklab, where equal distances look equally large. The sequential map rises in
// lightness at one rate from dark violet to light yellow, so that the order of values is seen
// without colour vision, too. The diverging map falls at one rate from light grey to blue and to
// red.

import type { Vec3 } from './vec.ts';

/// Number of colours of a map, sRGB 0…1, evenly spaced; CSS and the shader interpolate linearly.
export const kColours = 17;

const kDegrees = Math.PI / 180;

/// Converts Oklab lightness 0…1, chroma and hue [degrees] to sRGB, which may lie outside of 0…1.
function srgbOf(lightness: number, chroma: number, hue: number): Vec3 {
    const a = chroma * Math.cos(hue * kDegrees);
    const b = chroma * Math.sin(hue * kDegrees);
    const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
    const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
    const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
    const encoded = (x: number): number =>
        x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
    return [
        encoded(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
        encoded(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
        encoded(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
    ];
}

/// Converts to sRGB with the largest share of the chroma that a screen can show.
function shown(lightness: number, chroma: number, hue: number): Vec3 {
    for (let share = 1; ; share -= 0.02) {
        const colour = srgbOf(lightness, Math.max(share, 0) * chroma, hue);
        if (share <= 0 || colour.every((x) => x >= 0 && x <= 1))
            return colour.map((x) => Math.min(Math.max(x, 0), 1)) as unknown as Vec3;
    }
}

const spread = (colourAt: (t: number) => Vec3): readonly Vec3[] =>
    Array.from({ length: kColours }, (_, i) => colourAt(i / (kColours - 1)));

/// Sequential map, from small to large values.
export const kRising = spread((t) =>
    shown(0.25 + 0.67 * t, 0.13 + 0.05 * Math.sin(Math.PI * t), 305 - 195 * t),
);

/// Diverging map: blue below, grey in the middle, red above.
export const kDiverging = spread((t) => {
    const side = Math.abs(2 * t - 1);
    return shown(0.93 - 0.43 * side, 0.19 * side ** 0.9, t < 0.5 ? 258 : 32);
});

const kGolden = 137.508; // angle between successive hues, so that near numbers differ [degrees]

/// One of many distinct colours, by a number.
export function distinctColour(number: number): Vec3 {
    const n = Math.abs(Math.trunc(number));
    return shown([0.74, 0.62, 0.84][n % 3]!, 0.16, (40 + kGolden * n) % 360);
}

export const cssOf = (colour: Vec3): string =>
    `rgb(${colour.map((x) => Math.round(255 * x)).join(' ')})`;
