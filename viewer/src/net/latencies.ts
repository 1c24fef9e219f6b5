// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Latencies from a command to the arrival of the last box that it changed, and to the picture with
// it, of the last thousand commands.

import type { Done } from './protocol.ts';

const kMaxCount = 1000;

export class Latencies {
    private readonly open: { step: number; start: number }[] = [];
    private ready: number[] = [];
    readonly arrivedMs: number[] = [];
    readonly drawnMs: number[] = [];
    private seenStep = 0;

    /// Notes that a command is done. start: its time of sending [ms]
    done(answer: Done, start: number): void {
        if (!answer.moved_elements && !answer.cut_links && !answer.carved_elements) return;
        this.open.push({ step: answer.step, start });
        if (this.open.length > kMaxCount) this.open.shift();
        this.arrived(this.seenStep);
    }

    /// Notes that all voxels of a step have arrived.
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
    if (list.length > kMaxCount) list.shift();
}

/// Quantile of the values; undefined if there are none.
export function quantile(values: readonly number[], share: number): number | undefined {
    const sorted = [...values].sort((a, b) => a - b);
    return sorted[Math.min(Math.floor(share * sorted.length), sorted.length - 1)];
}
