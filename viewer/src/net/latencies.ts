// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// From a command to the voxels that it changed: the time until the last box of its step was here,
// and until it was drawn. Kept for the last thousand commands.

import type { Done } from './protocol.ts';

const kMost = 1000;

export class Latencies {
    private readonly open: { step: number; start: number }[] = [];
    private ready: number[] = [];
    readonly arrivedMs: number[] = [];
    readonly drawnMs: number[] = [];
    private seenStep = 0;

    /// A command that was sent at a time has been done.
    done(answer: Done, start: number): void {
        if (!answer.moved_elements && !answer.cut_links && !answer.carved_elements) return;
        this.open.push({ step: answer.step, start });
        if (this.open.length > kMost) this.open.shift();
        this.arrived(this.seenStep);
    }

    /// All voxels of a step are here.
    arrived(step: number): void {
        this.seenStep = Math.max(this.seenStep, step);
        const now = performance.now();
        while (this.open.length && this.open[0]!.step <= this.seenStep) {
            const { start } = this.open.shift()!;
            keep(this.arrivedMs, now - start);
            this.ready.push(start);
        }
    }

    drawn(): void {
        const now = performance.now();
        for (const start of this.ready) keep(this.drawnMs, now - start);
        this.ready = [];
    }
}

function keep(list: number[], value: number): void {
    list.push(value);
    if (list.length > kMost) list.shift();
}

/// The value below which a share of all lies; nothing where there are none.
export function quantile(values: readonly number[], share: number): number | undefined {
    const sorted = [...values].sort((a, b) => a - b);
    return sorted[Math.min(Math.floor(share * sorted.length), sorted.length - 1)];
}
