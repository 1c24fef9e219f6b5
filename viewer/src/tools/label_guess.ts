// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Recognises label maps, so that none is opened as a scan by mistake: by its name, or by few whole
// values in a NRRD, NIfTI or MetaImage file with its data.

/// Whether a name ends as those of label maps do: such a file is opened over the scan.
export const isLabelMap = (name: string): boolean =>
    /(\.seg|[-_. ](labels?|seg|segmentation|mask))\.(nrrd|nhdr|nii|nii\.gz|mha)$/i.test(name);

const kName = /(^|[^a-z])(labels?|labelmap|seg|segmentation|masks?)([^a-z]|$)/i;
const kHead = 4096; // bytes that hold a header's fields
const kMaxBytes = 64 << 20; // of the voxels that are looked at
const kMaxLabels = 64;
const kStride = 7; // every 7th voxel is looked at

type Numbers = 'int8' | 'uint8' | 'int16' | 'uint16' | 'int32' | 'uint32' | 'float32';

interface Layout {
    readonly type: Numbers;
    readonly littleEndian: boolean;
    readonly offset: number; ///< of the voxels, in the stream
    readonly packed: CompressionFormat | undefined; ///< of the bytes from offset on
}

const kSizes: Record<Numbers, number> = {
    int8: 1,
    uint8: 1,
    int16: 2,
    uint16: 2,
    int32: 4,
    uint32: 4,
    float32: 4,
};
const kNrrd: Record<string, Numbers> = {
    'signed char': 'int8',
    'unsigned char': 'uint8',
    uchar: 'uint8',
    short: 'int16',
    'unsigned short': 'uint16',
    ushort: 'uint16',
    int: 'int32',
    'unsigned int': 'uint32',
    uint: 'uint32',
    float: 'float32',
};
const kMeta: Record<string, Numbers> = {
    MET_CHAR: 'int8',
    MET_UCHAR: 'uint8',
    MET_SHORT: 'int16',
    MET_USHORT: 'uint16',
    MET_INT: 'int32',
    MET_UINT: 'uint32',
    MET_FLOAT: 'float32',
};
const kNifti: Record<number, Numbers> = {
    2: 'uint8',
    4: 'int16',
    8: 'int32',
    16: 'float32',
    256: 'int8',
    512: 'uint16',
    768: 'uint32',
};

/// Reason to take a file for a label map, as the end of a sentence; undefined: it is none.
export async function labelReason(name: string, file: Blob): Promise<string | undefined> {
    if (kName.test(name)) return 'by its name';
    const count = await countLabels(file).catch(() => undefined); // a broken file is no label map
    return count === undefined ? undefined : `it holds ${count} whole values`;
}

/// Number of labels; undefined if the values are no labels, or can't be read.
async function countLabels(file: Blob): Promise<number | undefined> {
    const start = new Uint8Array(await file.slice(0, 2).arrayBuffer());
    const isGzip = start[0] === 0x1f && start[1] === 0x8b;
    const whole = isGzip ? unpacked(file, 'gzip') : file.stream();
    const head = await take(whole, kHead);
    const layout = layoutOf(head);
    if (!layout) return undefined;
    const { offset, packed } = layout;
    const voxels = packed
        ? await take(unpacked(file.slice(offset), packed), kMaxBytes)
        : isGzip
          ? (await take(unpacked(file, 'gzip'), offset + kMaxBytes)).subarray(offset)
          : new Uint8Array(await file.slice(offset, offset + kMaxBytes).arrayBuffer());
    return labelsIn(voxels, layout);
}

const unpacked = (file: Blob, format: CompressionFormat): ReadableStream<Uint8Array> =>
    file.stream().pipeThrough(new DecompressionStream(format));

/// First bytes of a stream.
async function take(stream: ReadableStream<Uint8Array>, bytes: number): Promise<Uint8Array> {
    const pieces: Uint8Array[] = [];
    const reader = stream.getReader();
    let held = 0;
    while (held < bytes) {
        const { value, done } = await reader.read();
        if (done) break;
        pieces.push(value);
        held += value.length;
    }
    await reader.cancel();
    const joined = new Uint8Array(held);
    let at = 0;
    for (const piece of pieces) {
        joined.set(piece, at);
        at += piece.length;
    }
    return joined.subarray(0, bytes);
}

export function layoutOf(head: Uint8Array): Layout | undefined {
    const text = new TextDecoder('latin1').decode(head);
    if (text.startsWith('NRRD')) {
        const field = (name: string): string =>
            new RegExp(`^${name}: *(.*?)\\r?$`, 'mi').exec(text)?.[1]?.toLowerCase() ?? '';
        const end = /\r?\n\r?\n/.exec(text);
        const type = kNrrd[field('type').replace(/16_t|_t$/, '')];
        const encoding = field('encoding');
        if (!end || !type || field('data ?file') || !/^(raw|gz|gzip)$/.test(encoding))
            return undefined;
        return {
            type,
            littleEndian: field('endian') !== 'big',
            offset: end.index + end[0].length,
            packed: encoding === 'raw' ? undefined : 'gzip',
        };
    }
    const local = /^ElementDataFile *= *LOCAL\r?\n/m.exec(text);
    if (local) {
        const type = kMeta[/^ElementType *= *(\S+)/m.exec(text)?.[1] ?? ''];
        if (!type) return undefined;
        return {
            type,
            littleEndian: !/^(BinaryData|Element)ByteOrderMSB *= *True/m.test(text),
            offset: local.index + local[0].length,
            packed: /^CompressedData *= *True/m.test(text) ? 'deflate' : undefined,
        };
    }
    const view = new DataView(head.buffer, head.byteOffset, head.byteLength);
    if (head.length < 348 || text.slice(344, 347) !== 'n+1') return undefined;
    const littleEndian = view.getInt32(0, true) === 348;
    const type = kNifti[view.getInt16(70, littleEndian)];
    if (!type) return undefined;
    return {
        type,
        littleEndian,
        offset: Math.round(view.getFloat32(108, littleEndian)),
        packed: undefined,
    };
}

/// Number of labels among values; undefined if they are no labels: negative, fractions, or many.
/// One value alone says nothing.
export function labelsIn(
    bytes: Uint8Array,
    { type, littleEndian }: Pick<Layout, 'type' | 'littleEndian'>,
): number | undefined {
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const size = kSizes[type];
    const at = {
        int8: (i: number) => view.getInt8(i),
        uint8: (i: number) => view.getUint8(i),
        int16: (i: number) => view.getInt16(i, littleEndian),
        uint16: (i: number) => view.getUint16(i, littleEndian),
        int32: (i: number) => view.getInt32(i, littleEndian),
        uint32: (i: number) => view.getUint32(i, littleEndian),
        float32: (i: number) => view.getFloat32(i, littleEndian),
    }[type];
    const seen = new Set<number>();
    for (let i = 0; i + size <= bytes.length; i += kStride * size) {
        const value = at(i);
        if (seen.has(value)) continue;
        if (!Number.isInteger(value) || value < 0 || seen.size === kMaxLabels) return undefined;
        seen.add(value);
    }
    return seen.size > 1 ? seen.size : undefined;
}
