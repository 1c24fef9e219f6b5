// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Latency and number of bytes from a command to the texture. Views are not drawn meanwhile, because
// software rendering would take most of the machine; everything else is as usual. The clock runs
// from just before the command is sent until gl.finish reports that the last box of its step is in
// the texture. Rendering in hardware adds a frame.

import type { Vec3 } from '../src/maths/vec.ts';
import type { Session } from '../src/tools/session.ts';
import { BareBrowser, type Evaluator } from './bare_browser.ts';

export interface Push {
    readonly centre: Vec3; ///< of the sphere before the first push [mm]
    readonly radius: number; ///< [mm]
    readonly mm: number; ///< along x, to and fro
}

export interface LatencySettings extends Push {
    readonly warmUp: number; ///< number of pushes before the measured ones, even
    readonly count: number;
    readonly hertz: number;
}

/// Sample of one command; times since it was sent [ms].
export interface Sample {
    answered: number;
    mirrored: number; ///< until the last box is in the page's mirror
    textured: number; ///< until it is in the texture
    moved: number; ///< elements
}

export interface LatencyRun {
    readonly samples: Sample[];
    readonly refused: number;
    readonly hertz: number; ///< actual rate of commands
    readonly seconds: number;
    readonly boxBytes: number; ///< frames of boxes, with their headers
    readonly server: { solve: number[]; resample: number[]; tick: number[] }; ///< of each step [ms]
}

/// Opens a browser that shows the scan of a link.
export const openBare = (link: string): Promise<BareBrowser> =>
    BareBrowser.open(`${link}&notour`, () => {
        const { pliant } = window as never as { pliant?: Session };
        return Boolean(pliant && pliant.store.state.scan.loaded === 1 && pliant.stage.isStill);
    });

/// Pushes a ball of tissue to and fro at a fixed rate, without waiting for answers.
export async function measureLatency(
    page: Evaluator,
    wanted: LatencySettings,
): Promise<LatencyRun> {
    await page.evaluate(prepare);
    return page.evaluate(async ({ centre, radius, mm, warmUp, count, hertz }) => {
        const session = (window as never as { pliant: Session }).pliant;
        const { stage, store, connection } = session;
        const gl = stage.renderer.getContext();
        const draw = stage.frame;
        const take = session.box;
        const server = { solve: [] as number[], resample: [] as number[], tick: [] as number[] };
        const open: { step: number; start: number; sample: Sample }[] = [];
        const ends: { step: number; mirrored: number; textured: number }[] = [];
        let boxBytes = 0;
        let refused = 0;
        const settle = (): void => {
            for (const { step, start, sample } of open) {
                const end = ends.find((e) => e.step >= step);
                if (!end || sample.textured) continue;
                sample.mirrored = end.mirrored - start;
                sample.textured = end.textured - start;
            }
        };
        stage.frame = () => false;
        document.documentElement.style.display = 'none';
        session.box = (frame) => {
            take.call(session, frame);
            boxBytes += 32 + 2 * frame.halves.length;
            if (!frame.last) return;
            const mirrored = performance.now();
            stage.texture!.upload(stage.renderer);
            gl.finish();
            ends.push({ step: frame.step, mirrored, textured: performance.now() });
            settle();
        };
        let over = false;
        store.watch(
            ({ shared }) => [shared],
            (shared) => {
                if (over) return;
                const { solve_ms, resample_ms, tick_ms } = shared!.timing;
                server.solve.push(solve_ms);
                server.resample.push(resample_ms);
                server.tick.push(tick_ms);
            },
        );
        const samples: Sample[] = [];
        const answers: Promise<unknown>[] = [];
        const begin = performance.now();
        let counted = begin;
        for (let n = -warmUp; n < count; ++n) {
            if (n === 0) {
                counted = performance.now();
                boxBytes = 0;
                for (const list of Object.values(server)) list.length = 0;
            }
            const back = n % 2 !== 0;
            const point = [centre[0] + (back ? mm : 0), centre[1], centre[2]] as const;
            const push = [back ? -mm : mm, 0, 0] as const;
            const start = performance.now();
            const arrived = (answer: Awaited<ReturnType<typeof connection.ask>>): void => {
                if (answer?.t !== 'done') {
                    ++refused;
                    return;
                }
                const answered = performance.now() - start;
                const moved = answer.moved_elements ?? 0;
                const sample = { answered, mirrored: 0, textured: 0, moved };
                if (n >= 0) samples.push(sample);
                open.push({ step: answer.step, start, sample });
                settle();
            };
            answers.push(connection.ask({ do: 'push', point, push, radius }, arrived));
            const due = begin + (1000 * (n + warmUp + 1)) / hertz;
            const wait = due - performance.now();
            if (wait > 0) await new Promise((r) => setTimeout(r, wait));
        }
        const seconds = (performance.now() - counted) / 1000;
        await Promise.all(answers);
        for (let n = 0; n < 100 && open.some(({ sample }) => !sample.textured); ++n)
            await new Promise((r) => setTimeout(r, 100));
        if (!samples.every(({ textured }) => textured)) throw new Error('some voxels never came');
        over = true;
        session.box = take;
        stage.frame = draw;
        document.documentElement.style.display = '';
        return { samples, refused, hertz: count / seconds, seconds, boxBytes, server };
    }, wanted);
}

/// Numbers of voxels sent for one push, and of those that changed.
export interface BytesRun {
    readonly moved: number; ///< elements
    readonly changed: number; ///< voxels whose half floats changed
    readonly hull: number; ///< voxels of their bounding box
    readonly sent: number; ///< voxels
    readonly boxes: number;
    readonly bytes: number;
}

export async function measureBytes(page: Evaluator, push: Push): Promise<BytesRun> {
    await page.evaluate(prepare);
    return page.evaluate(async ({ centre, radius, mm }) => {
        const session = (window as never as { pliant: Session }).pliant;
        const take = session.box;
        const { halves, grid } = session.volume!;
        const before = halves.slice();
        let [sent, boxes, bytes] = [0, 0, 0];
        const steps = new Set<number>();
        session.box = (frame) => {
            take.call(session, frame);
            sent += frame.halves.length;
            ++boxes;
            bytes += 32 + 2 * frame.halves.length;
            if (frame.last) steps.add(frame.step);
        };
        const answer = await session.connection.ask({
            do: 'push',
            point: centre,
            push: [mm, 0, 0],
            radius,
        });
        if (answer?.t !== 'done') throw new Error('the push was not done');
        for (let n = 0; n < 100 && !steps.has(answer.step); ++n)
            await new Promise((r) => setTimeout(r, 50));
        if (!steps.has(answer.step)) throw new Error('the voxels of the push did not come');
        session.box = take;
        const least = [Infinity, Infinity, Infinity];
        const most = [-1, -1, -1];
        let changed = 0;
        const [nx, ny] = grid.size;
        for (let n = 0; n < halves.length; ++n) {
            if (halves[n] === before[n]) continue;
            ++changed;
            const at = [n % nx, Math.floor(n / nx) % ny, Math.floor(n / (nx * ny))];
            for (let a = 0; a < 3; ++a) {
                least[a] = Math.min(least[a]!, at[a]!);
                most[a] = Math.max(most[a]!, at[a]!);
            }
        }
        const hull = changed ? [0, 1, 2].reduce((v, a) => v * (most[a]! - least[a]! + 1), 1) : 0;
        return { moved: answer.moved_elements ?? 0, changed, hull, sent, boxes, bytes };
    }, push);
}

/// Resets the tissue, with materials that no push exceeds, and waits for all voxels. Runs in the
/// page.
async function prepare(): Promise<void> {
    const session = (window as never as { pliant: Session }).pliant;
    await session.ask({ do: 'materials', bone_threshold_hu: 30_000, max_movement_mm: 50 });
    await session.ask({ do: 'reset' });
    const same = await session.compare();
    if (!same?.same) throw new Error('the page has other voxels than the server');
}

export const quantile = (list: readonly number[], share: number): number => {
    const sorted = [...list].sort((a, b) => a - b);
    return sorted[Math.min(Math.ceil(share * sorted.length), sorted.length) - 1] ?? NaN;
};
