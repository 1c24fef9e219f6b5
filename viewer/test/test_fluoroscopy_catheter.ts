// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter in fluoroscopy, in front of bone and of vessels with contrast medium: it is darker
// than its surroundings over its whole length, by far more than the noise. The scan is a CT
// angiography, the catheter a curve through the aorta's lumen.

import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import type { Session } from '../src/tools/session.ts';
import { launch, picture, serve, still, visit } from './browser.ts';
import { insertCatheter, kAortaLumen } from './inserted_catheter.ts';
import { kAorta } from './setups.ts';

const kDarker = 20; // of 255; the noise there has a standard deviation of 3.5

type Held = { pliant: Session; bare: Uint8ClampedArray };

/// Visibility of the catheter: the smallest, over all rows that it crosses, of the largest
/// darkening of a row's pixels, of 255; and the number of rows.
async function darker(page: Page): Promise<{ least: number; rows: number }> {
    await page.waitForTimeout(300);
    await still(page);
    return page.evaluate(() => {
        const held = window as never as Held;
        const canvas = document.querySelector('canvas')!;
        const copy = document.createElement('canvas');
        copy.width = canvas.width;
        copy.height = canvas.height;
        const context = copy.getContext('2d')!;
        context.drawImage(canvas, 0, 0);
        const { data } = context.getImageData(0, 0, copy.width, copy.height);
        const rows: number[] = [];
        if (held.bare?.length === data.length)
            for (let y = 0; y < copy.height; ++y) {
                let most = 0;
                for (let i = 4 * copy.width * y; i < 4 * copy.width * (y + 1); i += 4)
                    most = Math.max(most, held.bare[i]! - data[i]!);
                if (most > 0) rows.push(most);
            }
        held.bare = data;
        const inner = rows.slice(5, -5); // without the ends and the collimator's edge
        return { least: Math.min(...inner), rows: rows.length };
    });
}

test(
    'a catheter is seen in front of bone and contrast agent',
    {
        skip: !process.env.PLIANT_SERVER || !existsSync(kAorta),
    },
    async () => {
        const browser = await launch();
        const served = await serve(kAorta);
        const { page, errors } = await visit(browser, served.link);
        for (const [name, look] of [
            ['front', [0, 1, 0]], // in front of the spine, across the heart
            ['side', [1, 0.2, 0]],
        ] as const) {
            await insertCatheter(page, []);
            await page.evaluate((look) => {
                const { store } = (window as never as Held).pliant;
                const orbit = {
                    ...store.state.view.orbit,
                    centre: [0, -149, 660] as const,
                    distance: 400,
                };
                const length = Math.hypot(...look);
                store.set({
                    view: {
                        outside: true,
                        fluoroscopy: true,
                        orbit: { ...orbit, direction: look.map((x) => x / length) as never },
                    },
                    display: { maximised: 'endoscope' },
                    fluoro: { noise: 0 },
                });
            }, look);
            await darker(page);
            await insertCatheter(page, kAortaLumen);
            const { least, rows } = await darker(page);
            console.log(`# ${name}: ${least} of 255 darker at least, ${rows} rows`);
            await page.evaluate(() =>
                (window as never as Held).pliant.store.set({ fluoro: { noise: 1 } }),
            );
            await page.waitForTimeout(300);
            await still(page);
            await picture(page, `fluoroscopy_catheter_${name}`);
            assert.ok(rows > 300, `${name}: ${rows} rows`);
            assert.ok(least > kDarker, `${name}: ${least} of 255`);
        }
        await browser.close();
        await served.stop();
        assert.deepEqual(errors, []);
    },
);
