// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Downloads: files that the browser saves.

export function download(url: string, name: string): void {
    const link = document.createElement('a');
    link.href = url;
    link.download = name;
    link.click();
}

export const saveBlob = (blob: Blob, name: string): void =>
    download(URL.createObjectURL(blob), name);
