// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Fluoroscopy in the browser and in the C++ renderer, of the same camera, on the phantom and, where
// it is at hand, on a CT: less than 0.5 of 255 apart on the mean.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import type { Session } from '../src/session.ts';
import { kPictures, launch, picture, rectOf, serve, stateOf, still, visit } from './browser.ts';
import { kThorax } from './setups.ts';

const program = process.env.PLIANT_SERVER;

async function compare(scan: string, name: string): Promise<void> {
    const browser = await launch();
    const served = await serve(scan);
    const { page, errors } = await visit(browser, served.link);
    await page.evaluate(() => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({ outside: true, fluoroscopy: true });
    });
    await page.waitForTimeout(300);
    await still(page);
    const { orbit } = await stateOf(page);
    const box = await rectOf(page, 'endoscope');
    const [width, height] = [Math.round(box.width), Math.round(box.height)];
    const shown = (2 * orbit.distance * Math.tan(Math.PI / 12) * width) / height;
    const file = join(kPictures, `${name}_cpp.png`);
    execFileSync(program!, [
        'render',
        scan,
        `--out=${file}`,
        '--view=fluoroscopy',
        `--at=${orbit.centre.join(',')}`,
        `--look=${orbit.direction.join(',')}`,
        `--up=${orbit.up.join(',')}`,
        `--source=${orbit.distance}`,
        `--width=${shown}`,
        `--size=${width}x${height}`,
    ]);
    await picture(page, `${name}_browser`);
    const url = `data:image/png;base64,${readFileSync(file).toString('base64')}`;
    const mean = await page.evaluate(async (source) => {
        const theirs = new Image();
        theirs.src = source;
        await theirs.decode();
        const pixelsOf = (image: CanvasImageSource): Uint8ClampedArray => {
            const copy = document.createElement('canvas');
            copy.width = theirs.width;
            copy.height = theirs.height;
            const context = copy.getContext('2d')!;
            context.drawImage(image, 0, 0);
            return context.getImageData(0, 0, copy.width, copy.height).data;
        };
        const a = pixelsOf(theirs);
        const b = pixelsOf(document.querySelector('canvas')!);
        let sum = 0;
        for (let i = 0; i < a.length; i += 4) sum += Math.abs(a[i]! - b[i]!);
        return (4 * sum) / a.length;
    }, url);
    console.log(`# ${name}: mean ${mean.toFixed(3)}`);
    await browser.close();
    await served.stop();
    assert.deepEqual(errors, []);
    assert.ok(mean < 0.5, `mean ${mean}`);
}

test('fluoroscopy of the phantom looks the same as in C++', { skip: !program }, async () => {
    const folder = mkdtempSync(join(tmpdir(), 'pliant-fluoroscopy-'));
    const scan = join(folder, 'airway.nrrd');
    execFileSync(program!, ['phantom', 'airway', '--size', '96', '--out', scan]);
    await compare(scan, 'fluoroscopy_phantom').finally(() => rmSync(folder, { recursive: true }));
});

test('fluoroscopy of a CT looks the same as in C++', {
    skip: !program || !existsSync(kThorax),
}, () => compare(kThorax, 'fluoroscopy_ct'));
