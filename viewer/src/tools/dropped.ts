// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Which files a scan is made of: what was dropped, with all that is in its folders, under names
// that can lie in one folder.

export interface NamedFile {
    readonly path: string; ///< with its folders
    readonly file: File;
}

export interface ScanFiles {
    readonly name: string; ///< of the scan, to be shown
    readonly files: readonly NamedFile[];
}

export const kMostFiles = 4096;

const kNoScan = /(^|\/)(\.[^/]*|Thumbs\.db|desktop\.ini)$/i;

const fileOf = (entry: FileSystemFileEntry): Promise<File> =>
    new Promise((resolve, reject) => entry.file(resolve, reject));

const someOf = (reader: FileSystemDirectoryReader): Promise<FileSystemEntry[]> =>
    new Promise((resolve, reject) => reader.readEntries(resolve, reject));

async function collect(entry: FileSystemEntry, path: string, files: NamedFile[]): Promise<void> {
    if (files.length > kMostFiles) throw new Error(`expected up to ${kMostFiles} files`);
    const own = path + entry.name;
    if (entry.isFile) {
        files.push({ path: own, file: await fileOf(entry as FileSystemFileEntry) });
        return;
    }
    // A reader hands out its entries bit by bit.
    const reader = (entry as FileSystemDirectoryEntry).createReader();
    for (let some = await someOf(reader); some.length; some = await someOf(reader))
        for (const inner of some) await collect(inner, `${own}/`, files);
}

/// All files that were dropped. To be called at once in the event: the list is gone afterwards.
export async function droppedFiles(data: DataTransfer): Promise<NamedFile[]> {
    const items = [...data.items].filter((item) => item.kind === 'file');
    const entries = items.map((item) => item.webkitGetAsEntry());
    const plain = items.map((item) => item.getAsFile());
    const files: NamedFile[] = [];
    for (const [n, entry] of entries.entries())
        if (entry) await collect(entry, '', files);
        else if (plain[n]) files.push({ path: plain[n].name, file: plain[n] });
    return files;
}

/// @throws an Error with one line where they can't be a scan
export function scanOf(all: readonly NamedFile[]): ScanFiles {
    const files = all.filter(({ path }) => !kNoScan.test(path));
    if (!files.length) throw new Error('expected a scan, found no file');
    if (files.length > kMostFiles)
        throw new Error(`expected up to ${kMostFiles} files, found ${files.length}`);
    if (files.length === 1) return { name: files[0]!.file.name, files };
    // A header names its data by their base names; only those that come twice get another one.
    const seen = new Set<string>();
    const named = files.map(({ path, file }) => {
        const base = path.split('/').pop()!;
        const free = seen.has(base) ? path.replaceAll('/', '_') : base;
        seen.add(free);
        return { path: free, file };
    });
    const [folder, ...below] = files[0]!.path.split('/');
    return { name: below.length ? folder! : 'scan', files: named };
}
