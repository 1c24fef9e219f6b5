// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scans in one upload, from which the user chooses one: DICOM series of a folder, or the images of
// a file, such as points in time. And the description in a DICOM file.

import type { Vec3 } from '../maths/vec.ts';

/// A series of a folder, as `pliant info` lists it.
export interface Series {
    readonly number: string; ///< may be empty, as may the description and the modality
    readonly description: string;
    readonly modality: string;
    readonly slices: number;
    readonly volumes: number;
    readonly size: Vec3; ///< of the first volume [voxels]; zeros: unknown
    readonly spacing_mm: Vec3; ///< of the first volume; zeros: unknown
    readonly uid: string;
    readonly fault?: string; ///< reason why it can't be read
}

export const kSeriesColumns = [
    'number',
    'description',
    'modality',
    'slices',
    'size',
    'spacing [mm]',
] as const;

/// Texts of a series for kSeriesColumns.
export function seriesRow(series: Series): string[] {
    const { number, description, modality, slices, volumes, size, spacing_mm, fault } = series;
    const isKnown = size[0] > 0;
    const extent = fault ? "can't be read" : isKnown ? size.join(' × ') : '';
    const several = volumes > 1 ? ` (${volumes} volumes)` : '';
    const spacing = spacing_mm.map((mm) => Number(mm.toPrecision(4))).join(' × ');
    return [
        number,
        description,
        modality,
        String(slices),
        extent + several,
        isKnown ? spacing : '',
    ];
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

const kHeaderBytes = 1 << 16;
const kDescription = [0x08, 0x00, 0x3e, 0x10]; // tag (0008,103E), little-endian
const kMaxDescription = 64;

/// Series description in a DICOM file; empty: none, or another format.
export async function seriesDescription(file: Blob): Promise<string> {
    const bytes = new Uint8Array(await file.slice(0, kHeaderBytes).arrayBuffer());
    const view = new DataView(bytes.buffer);
    if (new TextDecoder('latin1').decode(bytes.subarray(128, 132)) !== 'DICM') return '';
    for (let at = 132; at + 8 <= bytes.length; at += 2) {
        if (kDescription.some((byte, n) => bytes[at + n] !== byte)) continue;
        const isExplicit = view.getUint16(at + 4, true) === 0x4f4c; // "LO"
        const length = isExplicit ? view.getUint16(at + 6, true) : view.getUint32(at + 4, true);
        if (length > kMaxDescription || at + 8 + length > bytes.length) return '';
        const text = new TextDecoder().decode(bytes.subarray(at + 8, at + 8 + length));
        return text.replace(/[\0-\x1f]/g, ' ').trim();
    }
    return '';
}
