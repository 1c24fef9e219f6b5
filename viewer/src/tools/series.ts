// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// DICOM series: those of a folder, from which the user chooses one, and the description in a file.

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
