// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Set-up of most test files: one browser, one server and one page for all tests of a file. Errors
// of the page fail the file.

import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { launch, serve, serveAirway, type Served, visit } from './browser.ts';

export let browser: Browser;
export let served: Served;
export let page: Page;
let errors: string[] = [];

export interface Wishes {
    name?: string; ///< of the client, shown to others
    expected?: string; ///< part of the errors that the tests provoke
    size?: number; ///< voxels of the phantom along each side: smaller is faster
    file?: string; ///< instead of the phantom; the mock has none
    ready?: () => Promise<void>; ///< more to set up, when the page is open
}

/// Sets up the page. Called once, before the tests.
export function useOnePage({ name, expected, size, file, ready }: Wishes = {}): void {
    before(async () => {
        browser = await launch();
        served = await (size ? serveAirway(size) : serve(...(file ? [file] : [])));
        const more = name ? `&notour&name=${name}` : '&notour';
        ({ page, errors } = await visit(browser, served.link, more));
        await ready?.();
    });
    after(async () => {
        await browser.close();
        await served.stop();
        const complaints = errors.filter((line) => !expected || !line.includes(expected));
        assert.deepEqual(complaints, []);
    });
}
