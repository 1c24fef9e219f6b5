// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// DICOM slices of 8 × 6 pixels, byte by byte.

const kSyntax = '1.2.840.10008.1.2.1'; // explicit, little-endian
const kCt = '1.2.840.10008.5.1.4.1.1.2';

/// Encodes an element with its value representation.
function element(group: number, number: number, type: string, value: string | Buffer): Buffer {
    let bytes = typeof value === 'string' ? Buffer.from(value, 'latin1') : value;
    const fill = Buffer.alloc(bytes.length % 2, type === 'UI' ? 0 : ' ');
    bytes = Buffer.concat([bytes, fill]);
    const head = Buffer.alloc(type === 'OW' ? 12 : 8);
    head.writeUInt16LE(group, 0);
    head.writeUInt16LE(number, 2);
    head.write(type, 4, 'latin1');
    if (type === 'OW') head.writeUInt32LE(bytes.length, 8);
    else head.writeUInt16LE(bytes.length, 6);
    return Buffer.concat([head, bytes]);
}

const u16 = (value: number): Buffer => Buffer.from(Uint16Array.of(value).buffer);

/// Encodes a slice of a series at a height [mm]; all pixels have one value [HU].
export function dicomSlice(
    series: string,
    description: string,
    z: number,
    hu: number,
    number = '1',
): Buffer {
    const instance = `${series}.${z + 1}`;
    const meta = Buffer.concat([
        element(2, 0x0002, 'UI', kCt),
        element(2, 0x0003, 'UI', instance),
        element(2, 0x0010, 'UI', kSyntax),
    ]);
    const length = Buffer.from(Uint32Array.of(meta.length).buffer);
    const us = (number: number, value: number): Buffer => element(0x28, number, 'US', u16(value));
    return Buffer.concat([
        Buffer.alloc(128),
        Buffer.from('DICM'),
        element(2, 0, 'UL', length),
        meta,
        element(0x08, 0x0016, 'UI', kCt),
        element(0x08, 0x0018, 'UI', instance),
        element(0x08, 0x0060, 'CS', 'CT'),
        element(0x08, 0x103e, 'LO', description),
        element(0x20, 0x000e, 'UI', series),
        element(0x20, 0x0011, 'IS', number),
        element(0x20, 0x0032, 'DS', `0\\0\\${z}`),
        element(0x20, 0x0037, 'DS', '1\\0\\0\\0\\1\\0'),
        us(0x0002, 1),
        element(0x28, 0x0004, 'CS', 'MONOCHROME2'),
        us(0x0010, 6),
        us(0x0011, 8),
        element(0x28, 0x0030, 'DS', '1\\1'),
        us(0x0100, 16),
        us(0x0101, 16),
        us(0x0102, 15),
        us(0x0103, 1),
        element(0x28, 0x1052, 'DS', '0'),
        element(0x28, 0x1053, 'DS', '1'),
        element(0x7fe0, 0x0010, 'OW', Buffer.from(new Int16Array(48).fill(hu).buffer)),
    ]);
}
