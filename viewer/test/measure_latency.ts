// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// How long from a command to the voxels that it changed: pushes at 30 Hz on a CT, in a browser that
// doesn't draw (drawing in software would be measured instead). Printed are milliseconds from send
// to the last box of the step patched into the mirror and handed to the texture, the moved
// elements, and the bytes that came.
//
//   PLIANT_SERVER=build/release/pliant npm run measure
//   PLIANT_OVERLAY=jacobian            with displacement or jacobian asked for as well

import { existsSync } from 'node:fs';
import { join } from 'node:path';
import type { OverlayKind } from '../src/overlay_kinds.ts';
import type { Session } from '../src/session.ts';
import { kFolder, launch, serve, visit } from './browser.ts';

const data = process.env.PLIANT_SHARED_DATA ?? join(kFolder, '../../shared/data');
const ct = join(data, 'thorax_ct_256.nrrd');
if (!process.env.PLIANT_SERVER || !existsSync(ct))
    throw new Error(`expected PLIANT_SERVER, a program, and ${ct}`);
const kCount = 300;
const kHertz = 30;

const browser = await launch();
const served = await serve(ct);
const { page } = await visit(browser, served.link);
let bytes = 0;
page.on('websocket', (socket) => socket.on('framereceived', (f) => (bytes += f.payload.length)));
await page.reload();
await page.waitForFunction(
    () => (window as never as { pliant: Session }).pliant?.store.state.loaded === 1,
);
await page.waitForTimeout(2000);
bytes = 0;
const result = await page.evaluate(
    async ({ count, hertz, overlay }) => {
        const session = (window as never as { pliant: Session }).pliant;
        const { stage, store, latencies } = session;
        stage.frame = () => false;
        if (overlay) store.set({ overlay });
        const box = session.box.bind(session);
        session.box = (frame) => {
            box(frame);
            if (frame.last) stage.texture!.upload(stage.renderer);
        };
        // Soft tissue in the middle of the chest, to and fro; nothing counts as bone, so that each
        // push is done in full.
        await session.ask({ do: 'materials', bone_threshold_hu: 30_000, max_movement_mm: 200 });
        const { eye } = store.state.camera;
        const kPush = 9; // [mm]
        let moved: number[] = [];
        const answers: Promise<unknown>[] = [];
        const start = performance.now();
        for (let i = 0; i < count; ++i) {
            const side = i % 2 ? -kPush : kPush;
            const point = [eye[0] + 40 + (i % 2 ? kPush : 0), eye[1] + 70, eye[2] - 120] as const;
            const command = { do: 'push', point, push: [side, 0, 0], radius: 25 } as const;
            answers.push(
                session.connection.ask(command).then((a) => {
                    if (a?.t === 'done') moved.push(a.moved_elements ?? 0);
                }),
            );
            const wait = start + (1000 * (i + 1)) / hertz - performance.now();
            if (wait > 0) await new Promise((r) => setTimeout(r, wait));
        }
        await Promise.all(answers);
        const seconds = (performance.now() - start) / 1000;
        await new Promise((r) => setTimeout(r, 500));
        const quantile = (list: readonly number[], q: number): number =>
            [...list].sort((a, b) => a - b)[Math.floor(q * (list.length - 1))] ?? NaN;
        const { timing } = store.state.shared!;
        const { overlayVoxels } = store.state;
        return {
            pushes: moved.length,
            hertz: moved.length / seconds,
            movedMedian: quantile(moved, 0.5),
            p50: quantile(latencies.arrivedMs, 0.5),
            p99: quantile(latencies.arrivedMs, 0.99),
            solve: timing.solve_ms,
            resample: timing.resample_ms,
            overlay: timing.overlay_ms,
            overlaysHere: overlayVoxels,
        };
    },
    {
        count: kCount,
        hertz: kHertz,
        overlay: (process.env.PLIANT_OVERLAY ?? '') as OverlayKind | '',
    },
);
console.log(JSON.stringify({ ...result, megabytes: bytes / 1e6 }, null, 1));
await browser.close();
await served.stop();
