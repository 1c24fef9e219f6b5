// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The browser's picture and that of the C++ renderer, of the same camera: on the phantom and, where
// it is at hand, on a CT. They share the camera, the surface and the light, but not one line of
// code. Bounds, in 0…255: 0.5 on average over all pixels and channels, and at most 0.5 % of the
// pixels off by more than 16 (edges, where the two take their four rays per pixel differently). A
// camera that is off by half a degree is far outside of them.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import type { Browser } from 'playwright-core';
import { launch, serve, visit } from './browser.ts';
import { type Difference, difference } from './picture_difference.ts';
import type { Style } from '../src/store.ts';
import { kThorax } from './setups.ts';

const program = process.env.PLIANT_SERVER;
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
const kMostFar = 0.005;

/// The pictures of one scan, each in a style and with its camera off by so many degrees.
async function differences(
    scan: string,
    names: Record<string, [Style, number]>,
): Promise<Difference[]> {
    const served = await serve(scan);
    const { page, errors } = await visit(browser, served.link);
    const found: Difference[] = [];
    for (const [name, [style, off]] of Object.entries(names))
        found.push(await difference(page, scan, name, off, style));
    assert.deepEqual(errors, []);
    await page.context().close();
    await served.stop();
    return found;
}

const bound = ({ mean, far }: Difference): void =>
    assert.ok(mean < kMean && far < kMostFar, `mean ${mean}, far ${far}`);

test('the phantom looks the same as in C++, and not with half a degree more', {
    skip: !program,
}, async () => {
    const scan = join(folder, 'airway.nrrd');
    execFileSync(program!, ['phantom', 'airway', '--size', '128', '--out', scan]);
    const [same, off, real, realOff] = await differences(scan, {
        picture_phantom: ['plain', 0],
        picture_off: ['plain', 0.5],
        picture_phantom_real: ['real', 0],
        picture_real_off: ['real', 0.5],
    });
    bound(same!);
    assert.ok(off!.mean > kMean, `mean ${off!.mean}`);
    bound(real!);
    assert.ok(realOff!.mean > kMean, `mean ${realOff!.mean}`);
});

test('a CT looks the same as in C++', { skip: !program || !existsSync(kThorax) }, async () => {
    const [plain, real] = await differences(kThorax, {
        picture_ct: ['plain', 0],
        picture_ct_real: ['real', 0],
    });
    bound(plain!);
    bound(real!);
});
