// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files of a scan: dropped files and the contents of dropped folders, renamed so that they fit into
// one folder.

export interface NamedFile {
    readonly path: string; ///< including folders
    readonly file: File;
}

export interface ScanFiles {
    readonly name: string; ///< of the scan, for display
    readonly files: readonly NamedFile[];
}

export const kMaxFiles = 4096;
export const kUnnamed = 'scan'; ///< name of several files without a folder

const kNoScan = /(^|\/)(\.[^/]*|Thumbs\.db|desktop\.ini)$/i;

const fileOf = (entry: FileSystemFileEntry): Promise<File> =>
    new Promise((resolve, reject) => entry.file(resolve, reject));

const someOf = (reader: FileSystemDirectoryReader): Promise<FileSystemEntry[]> =>
    new Promise((resolve, reject) => reader.readEntries(resolve, reject));

async function collect(entry: FileSystemEntry, path: string, files: NamedFile[]): Promise<void> {
    if (files.length > kMaxFiles) throw new Error(`expected up to ${kMaxFiles} files`);
    const own = path + entry.name;
    if (entry.isFile) {
        files.push({ path: own, file: await fileOf(entry as FileSystemFileEntry) });
        return;
    }
    // A reader returns its entries in portions.
    const reader = (entry as FileSystemDirectoryEntry).createReader();
    for (let some = await someOf(reader); some.length; some = await someOf(reader))
        for (const inner of some) await collect(inner, `${own}/`, files);
}

/// Collects all dropped files. @pre called synchronously in the event, which owns the list
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

/// Selects the files of a scan. @throws an Error if they can't be one
export function scanOf(all: readonly NamedFile[]): ScanFiles {
    const files = all.filter(({ path }) => !kNoScan.test(path));
    if (!files.length) throw new Error('expected a scan, found no file');
    if (files.length > kMaxFiles)
        throw new Error(`expected up to ${kMaxFiles} files, found ${files.length}`);
    if (files.length === 1) return { name: files[0]!.file.name, files };
    // Headers name their data by base name; only duplicates are renamed.
    const seen = new Set<string>();
    const named = files.map(({ path, file }) => {
        const base = path.split('/').pop()!;
        const free = seen.has(base) ? path.replaceAll('/', '_') : base;
        seen.add(free);
        return { path: free, file };
    });
    const [folder, ...below] = files[0]!.path.split('/');
    return { name: below.length ? folder! : kUnnamed, files: named };
}
