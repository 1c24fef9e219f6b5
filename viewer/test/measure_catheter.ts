// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Drives a catheter to and fro in a vessel at the highest speed, in two pages. Prints its largest
// depth beyond the wall, whether both pages stay equal to the server, and the time taken. The pages
// draw nothing, because software rendering would take time from the simulation.
//
//   PLIANT_SERVER=build/release/pliant PLIANT_SCENE=scenes/vessel_aorta_live.toml
//       [PLIANT_SECONDS=40] [PLIANT_FAR_MM=80] npm run measure catheter
//
// PLIANT_SECONDS is simulated time. A page receives the state sixty times a second; `pliant vessel`
// examines every step.

import type { Page } from 'playwright-core';
import type { Command } from '../src/net/protocol.ts';
import type { Session } from '../src/tools/session.ts';
import { compare, launch, serve, stateOf, visit } from './browser.ts';

const kSeconds = Number(process.env.PLIANT_SECONDS ?? 40);
const kFar_mm = Number(process.env.PLIANT_FAR_MM ?? 80);
const kNear_mm = 5;
const kFastest_mm_s = 100;

interface Seen {
    depth: number; ///< largest value [mm]
    wall: number; ///< largest displacement of the wall [mm]
    force: number; ///< largest force [N]
    states: number;
    failure: string;
}

const watch = (page: Page): Promise<void> =>
    page.evaluate(() => {
        const session = (window as never as { pliant: Session }).pliant;
        session.stage.frame = () => false;
        const seen: Seen = { depth: -Infinity, wall: 0, force: 0, states: 0, failure: '' };
        (window as never as { seen: Seen }).seen = seen;
        session.store.watch(
            ({ shared }) => [shared],
            (shared) => {
                const vessel = shared?.vessel;
                if (!vessel) return;
                ++seen.states;
                seen.depth = Math.max(seen.depth, vessel.depth_mm);
                seen.wall = Math.max(seen.wall, vessel.wall_moved_mm);
                seen.force = Math.max(seen.force, Math.abs(vessel.force_n));
                seen.failure ||= vessel.failure;
            },
        );
    });
const seenBy = (page: Page): Promise<Seen> =>
    page.evaluate(() => (window as never as { seen: Seen }).seen);
const ask = (page: Page, command: Command): Promise<void> =>
    page.evaluate(async (c) => {
        await (window as never as { pliant: Session }).pliant.connection.ask(c);
    }, command);

const scene = process.env.PLIANT_SCENE;
if (!scene) throw new Error('PLIANT_SCENE: expected a scene of a vessel, found none');
if (!process.env.PLIANT_SERVER) throw new Error('PLIANT_SERVER: expected the program, found none');
const browser = await launch();
const served = await serve(scene);
const own = await visit(browser, served.link);
const other = await visit(browser, served.link, '&notour&role=view');
await watch(own.page);
await watch(other.page);

const begin = performance.now();
let ways = 0;
let time = 0;
for (; time < kSeconds; ++ways) {
    const away = ways % 2 === 0;
    const end = away ? kFar_mm : kNear_mm;
    await ask(own.page, { do: 'catheter', insert_mm_s: away ? kFastest_mm_s : -kFastest_mm_s });
    for (let before = NaN, still = 0; still < 20;) {
        await own.page.waitForTimeout(50);
        const { vessel } = (await stateOf(own.page)).shared!;
        time = vessel!.time_s;
        if (vessel!.failure || time >= kSeconds) break;
        if (away ? vessel!.inserted_mm >= end : vessel!.inserted_mm <= end) break;
        still = vessel!.inserted_mm === before ? still + 1 : 0;
        before = vessel!.inserted_mm;
    }
    if ((await seenBy(own.page)).failure) break;
}
await ask(own.page, { do: 'catheter', insert_mm_s: 0 });
for (let n = 0; n < 100 && !(await stateOf(own.page)).shared!.settled; ++n)
    await own.page.waitForTimeout(100);
const sums = await Promise.all([compare(own.page), compare(other.page)]);
console.log(
    JSON.stringify({
        simulated_s: time,
        seconds: (performance.now() - begin) / 1000,
        ways,
        own: await seenBy(own.page),
        other: await seenBy(other.page),
        same: sums.every((sum) => sum?.same) && sums[0]!.tissue === sums[1]!.tissue,
        errors: [...own.errors, ...other.errors],
    }),
);
await browser.close();
await served.stop();
