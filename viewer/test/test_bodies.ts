// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Several bodies in the page: each has a name and a colour of its own, and stripes show where
// they touch.

import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test, type TestContext } from 'node:test';
import type { Locator } from 'playwright-core';
import type { Session } from '../src/tools/session.ts';
import { picture, pixels, stateOf, untilState } from './browser.ts';
import { page, served, useOnePage } from './one_page.ts';
import { plateStl } from './plate.ts';

/// The plate, 12 mm thick, and another one behind it.
const folder = mkdtempSync(join(tmpdir(), 'pliant-bodies-'));
const file = join(folder, 'two.toml');
const front = plateStl();
const back = Buffer.from(front);
for (let at = 84 + 12; at < back.length; at += 50)
    for (let n = 4; n < 36; n += 12) back.writeFloatLE(back.readFloatLE(at + n) + 12.2, at + n);
writeFileSync(join(folder, 'front.stl'), front);
writeFileSync(join(folder, 'back.stl'), back);
writeFileSync(
    file,
    '[organs]\ntetrahedra = 3000\n' +
        ['front', 'back']
            .map((name) => `[[body]]\nname = "${name}"\nmesh = "${name}.stl"\n`)
            .join(''),
);
after(() => rmSync(folder, { recursive: true }));
useOnePage({ file });

const bodyTest = (name: string, run: (t: TestContext) => Promise<void>): void =>
    void test(name, async (t) => (served.mock ? t.skip('the mock has no bodies') : run(t)));

const panel = (): Locator =>
    page.locator('aside details', { has: page.locator('summary', { hasText: /^Tissue$/ }) });

bodyTest('each body has its name and a colour, in the panel and in the sections', async () => {
    await untilState(page, ({ labels }) => labels.list.length === 2 && labels.version > 1);
    const { list } = (await stateOf(page)).labels;
    assert.deepEqual(
        list.map(({ name, body }) => [name, body]),
        [
            ['front', 1],
            ['back', 2],
        ],
    );
    // Plain at first.
    assert.equal(await panel().locator('.organs li i').count(), 0);
    await panel().getByLabel('bodies in colours').check();
    const colours = await panel()
        .locator('.organs li i')
        .evaluateAll((marks) => marks.map((mark) => (mark as HTMLElement).style.background));
    assert.equal(colours.length, 2);
    assert.notEqual(colours[0], colours[1]);
    // The crosshair lies in the front plate.
    await page.evaluate(() =>
        (window as never as { pliant: Session }).pliant.store.set({
            sections: { cursor: [0, 0, 0] },
        }),
    );
    const under = await page.evaluate(() => {
        const { labelMap } = (window as never as { pliant: Session }).pliant;
        return [labelMap.at([0, 0, 0])?.name, labelMap.at([0, 12, 0])?.name];
    });
    assert.deepEqual(under, ['front', 'back']);
    await picture(page, 'bodies');
});

bodyTest('stripes show where bodies touch, on request', async () => {
    const box = panel().getByLabel('show where bodies touch');
    assert.equal(await box.isChecked(), false);
    const off = await pixels(page, 'axial');
    await box.check();
    const on = await pixels(page, 'axial');
    assert.notEqual(on.hash, off.hash);
    await picture(page, 'bodies_contact');
    await box.uncheck();
    assert.equal((await pixels(page, 'axial')).hash, off.hash);
});
