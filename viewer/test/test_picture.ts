// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The browser's picture and that of the C++ renderer, of the same camera: on the phantom and, where
// it is at hand, on a CT. They share the camera, the surface and the light, but not one line of
// code. Bounds, in 0…255: 0.5 on average over all pixels and channels, and at most 0.5 % of the
// pixels off by more than 16 (edges, where the two take their four rays per pixel differently). A
// camera that is off by half a degree is far outside of them.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import type { Browser } from 'playwright-core';
import type { Session } from '../src/session.ts';
import {
    kFolder,
    kPictures,
    launch,
    picture,
    rectOf,
    serve,
    stateOf,
    still,
    visit,
} from './browser.ts';

const program = process.env.PLIANT_SERVER;
const data = process.env.PLIANT_SHARED_DATA ?? join(kFolder, '../../shared/data');
const ct = join(data, 'thorax_ct_256.nrrd');
const folder = mkdtempSync(join(tmpdir(), 'pliant-picture-'));
let browser: Browser;
before(async () => {
    browser = await launch();
});
after(async () => {
    await browser.close();
    rmSync(folder, { recursive: true });
});

const kMean = 0.5;
const kFar = 16;
const kMostFar = 0.005;

async function difference(
    scan: string,
    name: string,
    offDegrees = 0,
): Promise<{ mean: number; far: number }> {
    const served = await serve(scan);
    const { page, errors } = await visit(browser, served.link);
    await page.evaluate(() => {
        const { stage, store } = (window as never as { pliant: Session }).pliant;
        (stage as never as { quality: number }).quality = 0;
        store.set({ fine: true });
        stage.invalidate();
    });
    await page.waitForTimeout(300);
    await still(page);
    const { camera, fieldOfView, barrel, fog, shared } = await stateOf(page);
    const box = await rectOf(page, 'endoscope');
    const file = join(kPictures, `${name}_cpp.png`);
    const size = `${Math.round(box.width)}x${Math.round(box.height)}`;
    execFileSync(program!, [
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
    ]);
    await picture(page, `${name}_browser`);
    const url = `data:image/png;base64,${readFileSync(file).toString('base64')}`;
    const result = await page.evaluate(
        async ({ source, far }) => {
            const theirs = new Image();
            theirs.src = source;
            await theirs.decode();
            const canvas = document.querySelector('canvas')!;
            const pixelsOf = (image: CanvasImageSource): Uint8ClampedArray => {
                const copy = document.createElement('canvas');
                copy.width = theirs.width;
                copy.height = theirs.height;
                const context = copy.getContext('2d')!;
                context.drawImage(image, 0, 0);
                return context.getImageData(0, 0, copy.width, copy.height).data;
            };
            const a = pixelsOf(theirs);
            const b = pixelsOf(canvas);
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
        { source: url, far: kFar },
    );
    assert.deepEqual(errors, []);
    await page.context().close();
    await served.stop();
    console.log(
        `# ${name}: mean ${result.mean.toFixed(2)}, far ${(100 * result.far).toFixed(2)} %`,
    );
    return result;
}

test('the phantom looks the same as in C++', { skip: !program }, async () => {
    const scan = join(folder, 'airway.nrrd');
    execFileSync(program!, ['phantom', 'airway', '--size', '128', '--out', scan]);
    const { mean, far } = await difference(scan, 'picture_phantom');
    assert.ok(mean < kMean && far < kMostFar, `mean ${mean}, far ${far}`);
});

test('a CT looks the same as in C++', { skip: !program || !existsSync(ct) }, async () => {
    const { mean, far } = await difference(ct, 'picture_ct');
    assert.ok(mean < kMean && far < kMostFar, `mean ${mean}, far ${far}`);
});

test('a camera with another field of view does not', { skip: !program }, async () => {
    const scan = join(folder, 'airway.nrrd');
    execFileSync(program!, ['phantom', 'airway', '--size', '128', '--out', scan]);
    const { mean } = await difference(scan, 'picture_off', 0.5);
    assert.ok(mean > kMean, `mean ${mean}`);
});
