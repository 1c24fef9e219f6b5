// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scans in one upload, from which the user chooses one: DICOM series of a folder, or the images of
// a file, such as points in time.

export interface Series {
    readonly uid: string;
    readonly description: string;
    readonly slices: number;
}

export interface Choices {
    readonly series?: readonly Series[];
    readonly frames?: number; ///< images, numbered from 0
}

/// The user's choice: parameters of the request that opens the scan.
export type Choice = { readonly series: string } | { readonly frame: string };

/// Parses the server's list. @throws an Error if it is none
export function readChoices(text: string): Choices {
    const choices = JSON.parse(text) as Choices;
    if (choices.series?.length || (choices.frames ?? 0) > 1) return choices;
    throw new Error('expected several series or images, found none');
}
