// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import type { Browser } from 'playwright-core';
import { compare, launch, picture, pixels, type Served, serve, visit } from './browser.ts';

let browser: Browser;
let served: Served;
before(async () => {
    browser = await launch();
    served = await serve();
});
after(async () => {
    await browser.close();
    await served.stop();
});

test("the scan is shown in four views, and its voxels are the server's", async () => {
    const { page, errors } = await visit(browser, served.link);
    for (const view of ['endoscope', 'axial', 'coronal', 'sagittal'] as const) {
        const { lit } = await pixels(page, view);
        assert.ok(lit > 0.15, `${view}: ${lit} of the pixels are lit`);
    }
    await picture(page, 'loaded');
    assert.equal((await compare(page))?.same, true);
    assert.deepEqual(errors, []);
});
