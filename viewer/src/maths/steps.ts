// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Steps of 1, 2 or 5 times a power of ten, and numbers with as many decimals as a step needs.

/// Largest step up to a value.
export function stepUpTo(value: number): number {
    const power = 10 ** Math.floor(Math.log10(value));
    const leading = [5, 2, 1].find((n) => n * power <= value)!;
    return Number((leading * power).toPrecision(1));
}

/// Step that is nearest to a value, by their ratio.
export function nearestStep(value: number): number {
    const power = 10 ** Math.floor(Math.log10(value));
    const bounds = [
        [1, Math.sqrt(2)],
        [2, Math.sqrt(10)],
        [5, Math.sqrt(50)],
        [10, Infinity],
    ] as const;
    const [leading] = bounds.find(([, end]) => value / power < end)!;
    return Number((leading * power).toPrecision(1));
}

/// Number of decimals of a step.
export const decimalsOf = (step: number): number =>
    Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));

/// Nearest multiple of a step.
export const roundTo = (value: number, step: number): number =>
    Number((Math.round(value / step) * step).toFixed(decimalsOf(step)));

/// Text of a number, with the decimals of a step; zero has no sign.
export function fixed(value: number, step: number): string {
    const text = value.toFixed(decimalsOf(step));
    return Number(text) === 0 ? text.replace('-', '') : text;
}
