// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Compares the browser's picture of the endoscope, or any other picture of the first view, pixel by
// pixel with the C++ renderer's of the same camera.

import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import type { Camera } from '../src/maths/rays.ts';
import type { FieldStop, Lining, Style } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import { kPictures, picture, rectOf, stateOf, still } from './browser.ts';

/// Difference of a channel above which a pixel is far off, of 255.
export const kFar = 16;

export interface Difference {
    readonly mean: number; ///< over all pixels and channels, of 255
    readonly far: number; ///< share of the pixels that are far off
    readonly camera: string; ///< as text
}

/// Settings of both pictures; absent ones stay as they are in the page.
export interface Shown {
    readonly lining?: Lining;
    readonly fieldStop?: FieldStop;
    readonly camera?: Camera;
    readonly fine?: boolean; ///< four rays per pixel; default: true
    readonly quality?: number; ///< level of reduced resolution; 0: full
    /// File of `pliant deform --save-state` with the state of the page's tissue.
    readonly state?: string;
}

/// Difference of the view in the canvas's upper left corner and a picture in a file.
/// @param left  begin of the part that is compared, in the canvas [pixels]
export async function pixelDifference(
    page: Page,
    file: string,
    left = 0,
): Promise<Pick<Difference, 'mean' | 'far'>> {
    const url = `data:image/png;base64,${readFileSync(file).toString('base64')}`;
    return page.evaluate(
        async ({ source, far, left }) => {
            const theirs = new Image();
            theirs.src = source;
            await theirs.decode();
            const canvas = document.querySelector('canvas')!;
            const pixelsOf = (image: CanvasImageSource, x: number): Uint8ClampedArray => {
                const copy = document.createElement('canvas');
                copy.width = theirs.width;
                copy.height = theirs.height;
                const context = copy.getContext('2d')!;
                context.drawImage(image, -x, 0);
                return context.getImageData(0, 0, copy.width, copy.height).data;
            };
            const a = pixelsOf(theirs, 0);
            const b = pixelsOf(canvas, left);
            let sum = 0;
            let many = 0;
            for (let i = 0; i < a.length; i += 4) {
                let most = 0;
                for (let c = 0; c < 3; ++c) {
                    const d = Math.abs(a[i + c]! - b[i + c]!);
                    sum += d;
                    most = Math.max(most, d);
                }
                if (most > far) ++many;
            }
            return { mean: sum / (0.75 * a.length), far: many / (a.length / 4) };
        },
        { source: url, far: kFar, left },
    );
}

/// Draws both pictures and compares them.
/// @param scan  file of the page's scan
/// @param name  of the pictures in test/out
/// @param offDegrees  added to the field of view of the C++ picture
/// @param style  of both
export async function difference(
    page: Page,
    scan: string,
    name: string,
    offDegrees = 0,
    style: Style = 'plain',
    { state: saved, quality = 0, ...shown }: Shown = {},
): Promise<Difference> {
    await page.evaluate(
        async ({ quality, ...settings }) => {
            const session = (window as never as { pliant: Session }).pliant;
            const { stage, store } = session;
            (stage as never as { quality: number }).quality = quality;
            const { camera, fine = true, ...look } = settings;
            store.set({ display: { fine }, look, view: camera ? { camera } : {} });
            await session.compare(); // its answer comes after the rest field
            stage.invalidate();
        },
        { style, quality, ...shown },
    );
    await page.waitForTimeout(300);
    await still(page);
    const { view, look, shared } = await stateOf(page);
    const { camera, fieldOfView, barrel, fog } = view;
    const { lining, fieldStop } = look;
    const box = await rectOf(page, 'endoscope');
    const file = join(kPictures, `${name}_cpp.png`);
    const size = `${Math.round(box.width)}x${Math.round(box.height)}`;
    execFileSync(process.env.PLIANT_SERVER!, [
        'render',
        scan,
        `--out=${file}`,
        '--view=endoscope',
        `--eye=${camera.eye.join(',')}`,
        `--look=${camera.look.join(',')}`,
        `--up=${camera.up.join(',')}`,
        `--size=${size}`,
        `--fov=${fieldOfView + offDegrees}`,
        `--barrel=${barrel}`,
        `--fog=${fog}`,
        `--iso=${shared!.iso_hu}`,
        `--polarity=${shared!.polarity}`,
        `--style=${style}`,
        `--lining=${lining}`,
        `--field=${fieldStop}`,
        ...(saved ? [`--load-state=${saved}`] : []),
    ]);
    await picture(page, `${name}_browser`);
    const result = await pixelDifference(page, file);
    console.log(
        `# ${name}: mean ${result.mean.toFixed(2)}, far ${(100 * result.far).toFixed(2)} %`,
    );
    const at = camera.eye.map((x) => x.toFixed(1)).join(', ');
    return { ...result, camera: `${size} pixels, ${fieldOfView}°, at (${at}) mm` };
}
