// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A folder may hold several DICOM series: the user says which one is meant.

export interface Series {
    readonly uid: string;
    readonly description: string;
    readonly slices: number;
}

/// The server's list. @throws an Error with one line where it is none
export function readSeries(text: string): Series[] {
    const { series } = JSON.parse(text) as { series?: Series[] };
    if (!Array.isArray(series) || !series.length) throw new Error('expected a list of series');
    return series;
}
