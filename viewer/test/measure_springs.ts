// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Springs on a CT of an abdomen: 20³ nodes under its wall, pressed at 30 Hz, for several depths.
// Prints the numbers of the page; pictures show the state before and after. Nothing is drawn
// meanwhile, because software rendering would dominate the times.
//
//   PLIANT_SERVER=build/release/pliant npm run measure springs

import { existsSync } from 'node:fs';
import { join } from 'node:path';
import type { Session } from '../src/tools/session.ts';
import { kFolder, launch, picture, serve, stateOf, still, visit } from './browser.ts';

const data = process.env.PLIANT_SHARED_DATA ?? join(kFolder, '../../shared/data');
const ct = join(data, 'abdomen_ct_3mm.nii.gz');
if (!process.env.PLIANT_SERVER || !existsSync(ct))
    throw new Error(`expected PLIANT_SERVER, a program, and ${ct}`);
const kDepths = [10, 5];
const kCentre = [0, -200, 260] as const;
const kSkin = [0, -262, 260] as const;

const browser = await launch();
const served = await serve(ct);
const { page } = await visit(browser, served.link);
await page.evaluate((cursor) => {
    const { store } = (window as never as { pliant: Session }).pliant;
    store.set({
        sections: { cursor: [cursor[0], cursor[1] + 6, cursor[2]] },
        view: {
            fog: 0,
            camera: { eye: [110, -400, 300], look: [-0.61, 0.76, -0.23], up: [0, 0, 1] },
        },
    });
}, kSkin);
await page.evaluate(() =>
    (window as never as { pliant: Session }).pliant.ask({ do: 'iso', iso_hu: -300 }),
);
await page.locator('summary', { hasText: /^Tissue$/ }).click();
await still(page);
await picture(page, 'springs_abdomen_before');

const run = (depth: number): Promise<unknown> =>
    page.evaluate(
        async ({ depth, centre, skin }) => {
            const session = (window as never as { pliant: Session }).pliant;
            const { stage, store } = session;
            const frame = stage.frame.bind(stage);
            stage.frame = () => false;
            const wait = (ms: number): Promise<void> => new Promise((r) => setTimeout(r, ms));
            const place = { centre, nodes: 20, cell_mm: 9 };
            await session.ask({ do: 'tissue', model: 'springs', ...place });
            await session.ask({ do: 'depth', layers: depth });
            // To and fro for three seconds.
            let at = 0;
            const forward: number[] = [];
            const answers: number[] = [];
            const start = performance.now();
            for (let n = 1; performance.now() - start < 3000; ++n) {
                const to = 12 * (1 - Math.cos((n / 45) * Math.PI));
                const since = performance.now();
                void session.connection
                    .ask({
                        do: 'push',
                        point: [skin[0], skin[1] + at, skin[2]],
                        push: [0, to - at, 0],
                        radius: 25,
                    })
                    .then((a) => {
                        answers.push(performance.now() - since);
                        if (a?.t === 'done') forward.push(a.step_fraction ?? 0);
                    });
                at = to;
                await wait(start + (1000 * n) / 30 - performance.now());
            }
            const text = (): string => document.querySelector('.springs')!.textContent!;
            const pushed = text();
            await wait(1500);
            stage.frame = frame;
            const { timing } = store.state.shared!;
            answers.sort((a, b) => a - b);
            return {
                depth,
                pushed,
                later: text(),
                pushes: answers.length,
                whole: forward.filter((f) => f === 1).length,
                answer_ms: answers[Math.floor(answers.length / 2)],
                timing,
            };
        },
        { depth, centre: kCentre, skin: kSkin },
    );
for (const depth of kDepths) console.log(JSON.stringify(await run(depth)));

// A visible push.
await run(10);
await page.evaluate(async (skin) => {
    const session = (window as never as { pliant: Session }).pliant;
    await session.ask({ do: 'reset' });
    await session.ask({ do: 'push', point: skin, push: [0, 24, 0], radius: 25 });
}, kSkin);
await page.waitForTimeout(3000);
await still(page);
await picture(page, 'springs_abdomen_after');
console.log(JSON.stringify((await stateOf(page)).shared!.tissue));
await browser.close();
await served.stop();
