// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Links that are not valid, and servers that hang: the page says so within seconds.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import {
    launch,
    picture,
    serve,
    type Served,
    spot,
    stateOf,
    untilState,
    visit,
} from './browser.ts';

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

const notice = (page: Page): Promise<string | null> => page.locator('.notice').textContent();
const kRefused =
    'This link is not valid, or no longer. Open the link that pliant serve printed last.';

test('a link with a wrong token is told from a server that is away, within 5 s', async () => {
    const page = await (await browser.newContext()).newPage();
    await page.goto(served.link.replace(/token=\w+/, 'token=0123'));
    await untilState(page, ({ link }) => link.status === 'refused', 5);
    assert.equal(await notice(page), kRefused);
    assert.equal(await page.locator('#link').textContent(), 'not connected');
    await picture(page, 'link_refused');
    await page.context().close();
});

test('after a restart of the server the old link is no longer valid', async (t) => {
    if (!served.mock) return t.skip('the mock can change its token');
    const { page } = await visit(browser, served.link);
    served.mock.token = 'another';
    served.mock.breakLines();
    await untilState(page, ({ link }) => link.status === 'refused', 5);
    assert.equal(await notice(page), kRefused);
    served.mock.token = 'mock';
    await page.context().close();
});

test('a server that hangs is noticed within 5 s, and so is its return', async () => {
    const { page } = await visit(browser, served.link);
    served.freeze(true);
    await untilState(page, ({ link }) => link.silent, 5);
    assert.match((await notice(page))!, /does not answer/);
    assert.equal(await page.locator('#link').textContent(), 'no answer');
    await picture(page, 'link_silent');
    const iso = (await stateOf(page)).shared!.iso_hu;
    await page.mouse.move(...(await spot(page, 'axial')));
    await page.keyboard.press('Period');
    served.freeze(false);
    await untilState(page, ({ link }) => !link.silent, 10);
    await page.locator('.notice').waitFor({ state: 'hidden' });
    await untilState(page, ({ shared }) => shared!.iso_hu !== iso, 10); // it has waited
    await page.context().close();
});
