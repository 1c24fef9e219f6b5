// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Endurance test: a simulated device pushes the phantom for ten minutes, with a second browser as a
// viewer. Both pages draw nothing, because software rendering would take time from server and
// servo. Prints once a minute and at the end: messages of the device in each page, the longest time
// without one, compared checksums, and the servo's timing.
//
//   PLIANT_SERVER=… [PLIANT_MINUTES=10] [PLIANT_OUT=FILE] npm run measure haptics
//
// The final output is written to PLIANT_OUT as well.

import { writeFileSync } from 'node:fs';
import type { Page } from 'playwright-core';
import type { Session } from '../src/tools/session.ts';
import { compare, launch, serve, stateOf, visit } from './browser.ts';

const kMinutes = Number(process.env.PLIANT_MINUTES ?? 10);
const kCompareMs = 10_000;

interface Watched {
    news: number;
    longestMs: number;
    pushes: number; ///< contacts begun
    lost: number; ///< losses of the connection
}

const watch = (page: Page): Promise<void> =>
    page.evaluate(() => {
        const session = (window as never as { pliant: Session }).pliant;
        session.stage.frame = () => false;
        const seen = { news: 0, longestMs: 0, pushes: 0, lost: 0 };
        (window as never as { seen: typeof seen }).seen = seen;
        let last = 0;
        let touches = false;
        session.store.listen(({ link, device }, before) => {
            if (link.status !== before.link.status && link.status !== 'open') ++seen.lost;
            if (device.news === before.device.news || !device.news) return;
            const now = performance.now();
            if (last) seen.longestMs = Math.max(seen.longestMs, now - last);
            last = now;
            ++seen.news;
            if (device.news.contact && !touches) ++seen.pushes;
            touches = device.news.contact!;
        });
    });
const seenBy = (page: Page): Promise<Watched> =>
    page.evaluate(() => (window as never as { seen: Watched }).seen);

const browser = await launch();
const served = await serve();
const own = await visit(browser, served.link);
const other = await visit(browser, served.link, '&notour&role=view');
await watch(own.page);
await watch(other.page);
const mark = (await stateOf(own.page)).scan.volume!.landmarks[0]!;
const started = await own.page.evaluate(async ({ eye_mm, look }) => {
    const session = (window as never as { pliant: Session }).pliant;
    session.endoscope.goTo(eye_mm, look);
    session.endoscope.fly(look.map((x) => 60 * x) as [number, number, number]);
    session.device.device = 'virtual:tap';
    return session.device.start();
}, mark);
if (!started) throw new Error('the device didn’t start');

const end = Date.now() + 60_000 * kMinutes;
let compared = 0;
let different = 0;
for (let n = 1; Date.now() < end; ++n) {
    await own.page.waitForTimeout(Math.min(kCompareMs, Math.max(end - Date.now(), 0)));
    const sums = await Promise.all([compare(own.page), compare(other.page)]);
    // Each page is compared with the server: the two pages have the same step only at rest.
    compared += 2;
    different += sums.filter((sum) => !sum?.same).length;
    if (n % 6) continue;
    const { news } = (await stateOf(own.page)).device;
    console.log(JSON.stringify({ s: (n * kCompareMs) / 1000, ...news!.servo, different }));
}
const found = JSON.stringify({
    minutes: kMinutes,
    own: await seenBy(own.page),
    other: await seenBy(other.page),
    compared,
    different,
    errors: [...own.errors, ...other.errors],
    undo: (await stateOf(own.page)).shared!.undo.steps,
    servo: (await stateOf(own.page)).device.news?.servo,
});
console.log(found);
if (process.env.PLIANT_OUT) writeFileSync(process.env.PLIANT_OUT, `${found}\n`);
await browser.close();
await served.stop();
