// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Springs on a CT of an abdomen over slow lines: 20³ nodes under its wall, pressed at 30 Hz, with
// the depth chosen and automatic. The client has no page, so that the line is the limit.
//
//   PLIANT_SERVER=build/release/pliant npm run measure traffic

import { serve } from './browser.ts';
import { kAbdomen } from './setups.ts';
import { slowLine } from './throttle.ts';
import { Wire } from './wire.ts';

const kCentre = [0, -200, 260] as const;
const kSkin = [0, -262, 260] as const;
const kHertz = 30;
const kDepth = 10; ///< at the start
const kDepths = [20, 15, 10, 7, 5, 3, 2, 1];
const kRates = [1, 2, 4, 8, 16, Infinity]; ///< [MB/s]
const kSettling = Number(process.env.PLIANT_SETTLING ?? 15); ///< [s]
const kMeasured = 5; ///< [s]

const served = await serve(kAbdomen);
const line = await slowLine(Infinity);
line.target = Number(new URL(served.link).port);
const wire = await Wire.open(served.link, line.port);
let [bytes, updates] = [0, 0];
wire.onBox = (box, size) => {
    bytes += size;
    updates += Number(box.last);
};
const pause = (ms: number): Promise<void> => new Promise((done) => setTimeout(done, ms));

/// Presses to and fro.
async function press(seconds: number): Promise<void> {
    let at = 0;
    const start = performance.now();
    for (let n = 1; performance.now() - start < 1000 * seconds; ++n) {
        const to = 12 * (1 - Math.cos((n / 45) * Math.PI));
        void wire.ask({
            do: 'push',
            point: [kSkin[0], kSkin[1] + at, kSkin[2]],
            push: [0, to - at, 0],
            radius: 25,
        });
        at = to;
        await pause(start + (1000 * n) / kHertz - performance.now());
    }
}

interface Run {
    hertz: number;
    kilobytes: number; ///< of an update
    depth: number;
    pace: number; ///< updates of the nodes per second
}

async function run(depth: number, automatic: boolean, rate: number): Promise<Run> {
    line.rate = Infinity;
    await wire.ask({ do: 'tissue', model: 'springs', centre: kCentre, nodes: 20, cell_mm: 9 });
    await wire.ask({ do: 'depth', layers: depth });
    if (automatic) await wire.ask({ do: 'depth', by_time: true });
    await pause(500);
    line.rate = 1e6 * rate;
    await press(automatic ? kSettling : 1);
    [bytes, updates] = [0, 0];
    const start = performance.now();
    await press(kMeasured);
    const seconds = (performance.now() - start) / 1000;
    return {
        hertz: updates / seconds,
        kilobytes: bytes / updates / 1000,
        depth: wire.state!.tissue!.depth!,
        pace: wire.state!.tissue!.update_hz!,
    };
}

await pause(1000);
const text = (r: Run): string =>
    `${r.hertz.toFixed(1)} updates/s, ${r.kilobytes.toFixed(0)} kB each, depth ${r.depth}, ` +
    `nodes at ${r.pace.toFixed(0)} Hz`;
for (const depth of kDepths)
    console.log(`depth ${depth}, no limit: ${text(await run(depth, false, Infinity))}`);
for (const rate of kRates)
    for (const automatic of [false, true])
        console.log(
            `${rate} MB/s, ${automatic ? 'automatic' : 'chosen'}: ` +
                text(await run(kDepth, automatic, rate)),
        );
wire.close();
line.stop();
await served.stop();
