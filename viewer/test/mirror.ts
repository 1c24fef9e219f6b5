// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Copies of a page's voxels and pixels, for references that are computed in the tests.

import type { Page } from 'playwright-core';
import type { Grid } from '../src/maths/grid.ts';
import { VolumeData } from '../src/maths/volume.ts';
import type { ViewName } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import { still } from './browser.ts';

/// Copies the page's mirror of the deformed scan.
export async function mirrorOf(page: Page): Promise<VolumeData> {
    const { grid, text } = await page.evaluate(() => {
        const { volume } = (window as never as { pliant: Session }).pliant;
        const bytes = new Uint8Array(volume!.halves.buffer);
        let all = '';
        for (let i = 0; i < bytes.length; i += 8192)
            all += String.fromCharCode(...bytes.subarray(i, i + 8192));
        return { grid: volume!.grid as Grid, text: btoa(all) };
    });
    const bytes = Uint8Array.from(Buffer.from(text, 'base64'));
    return new VolumeData(grid, new Uint16Array(bytes.buffer));
}

export interface ViewPixels {
    readonly width: number;
    readonly height: number;
    readonly data: Uint8Array; ///< RGBA, rows from the top
}

/// Pixels of a view without the marks over them.
export async function pixelsOf(page: Page, view: ViewName): Promise<ViewPixels> {
    await still(page);
    const { width, height, text } = await page.evaluate((name) => {
        const canvas = document.querySelector('canvas')!;
        const own = canvas.getBoundingClientRect();
        const box = document.querySelector(`.view.${name}`)!.getBoundingClientRect();
        const ratio = canvas.width / own.width;
        const left = Math.round((box.left - own.left) * ratio);
        const top = Math.round((box.top - own.top) * ratio);
        const copy = document.createElement('canvas');
        copy.width = Math.round((box.right - own.left) * ratio) - left;
        copy.height = Math.round((box.bottom - own.top) * ratio) - top;
        const context = copy.getContext('2d')!;
        context.drawImage(canvas, -left, -top);
        const { data } = context.getImageData(0, 0, copy.width, copy.height);
        let all = '';
        for (let i = 0; i < data.length; i += 8192)
            all += String.fromCharCode(...data.subarray(i, i + 8192));
        return { width: copy.width, height: copy.height, text: btoa(all) };
    }, view);
    return { width, height, data: Uint8Array.from(Buffer.from(text, 'base64')) };
}
