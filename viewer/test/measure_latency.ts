// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Prints latencies from a command to the texture (latency.ts): pushes at 30 Hz in the heart of a
// CT, in a browser that draws nothing.
//
//   PLIANT_SERVER=build/release/pliant npm run measure -- latency
//   PLIANT_OVERLAY=jacobian            with the overlay displacement or jacobian

import type { OverlayKind } from '../src/net/protocol.ts';
import type { Session } from '../src/tools/session.ts';
import { serve } from './browser.ts';
import { measureLatency, openBare, quantile } from './latency.ts';
import { kRun, thorax } from './setups.ts';
import { watched } from './stolen.ts';

const served = await serve(thorax());
const page = await openBare(served.link);
await page.evaluate(
    (overlay) => {
        const { store } = (window as never as { pliant: Session }).pliant;
        if (overlay) store.set({ overlay: { kind: overlay } });
    },
    (process.env.PLIANT_OVERLAY ?? '') as OverlayKind | '',
);
const run = await watched(() => measureLatency(page, { ...kRun, count: 300 }));
const { samples, server } = run;
const spread = (of: (s: (typeof samples)[0]) => number): string =>
    [0.5, 0.99, 1].map((q) => quantile(samples.map(of), q).toFixed(1)).join(' ');
console.log(`${samples.length} pushes at ${run.hertz.toFixed(1)} Hz, refused ${run.refused}`);
console.log(`stolen by other virtual machines: ${(100 * run.stolen).toFixed(1)} % of the time`);
console.log(`moved elements, least: ${Math.min(...samples.map((s) => s.moved))}`);
console.log('milliseconds: median, 99th percentile, most');
console.log(`  answered  ${spread((s) => s.answered)}`);
console.log(`  mirrored  ${spread((s) => s.mirrored)}`);
console.log(`  textured  ${spread((s) => s.textured)}`);
for (const [name, list] of Object.entries(server))
    console.log(`  ${name.padEnd(9)} ${[0.5, 0.99, 1].map((q) => quantile(list, q)).join(' ')}`);
console.log(`bytes of boxes per push: ${Math.round(run.boxBytes / samples.length)}`);
await page.close();
await served.stop();
