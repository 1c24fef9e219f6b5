// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Gives files to the browser to save.

export function download(url: string, name: string): void {
    const link = document.createElement('a');
    link.href = url;
    link.download = name;
    link.click();
}

export const saveBlob = (blob: Blob, name: string): void =>
    download(URL.createObjectURL(blob), name);
