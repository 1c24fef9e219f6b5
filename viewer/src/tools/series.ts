// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// DICOM series of a folder, from which the user chooses one.

export interface Series {
    readonly uid: string;
    readonly description: string;
    readonly slices: number;
}

/// Parses the server's list. @throws an Error if it is none
export function readSeries(text: string): Series[] {
    const { series } = JSON.parse(text) as { series?: Series[] };
    if (!Array.isArray(series) || !series.length) throw new Error('expected a list of series');
    return series;
}
