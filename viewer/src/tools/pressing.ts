// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Press and hold: a probe that is held on a wall without moving goes into it, along the ray under
// the pointer. So a trackpad or a finger can press without a wheel.

const kHoldMs = 400; // until a press begins
const kTickMs = 40;
const kTremble = 12; // [pixels]
const kSpeed = 8; // [mm/s]

export class Pressing {
    private waiting = 0;
    private ticking = 0;

    /// Begins to wait. @param begin  called when the press begins; @returns whether it may
    /// @param advance  called with each motion into the wall [mm]
    wait(begin: () => boolean, advance: (way: number) => void): void {
        this.stop();
        this.waiting = setTimeout(() => {
            if (!begin()) return;
            let last = performance.now();
            this.ticking = setInterval(() => {
                const now = performance.now();
                advance((kSpeed * Math.min(now - last, 4 * kTickMs)) / 1000);
                last = now;
            }, kTickMs) as unknown as number;
        }, kHoldMs) as unknown as number;
    }

    /// Ends a press that has begun, or the wait for one.
    stop(): void {
        clearTimeout(this.waiting);
        clearInterval(this.ticking);
        this.ticking = 0;
    }

    /// Ends the wait, since the pointer has moved; a press that has begun goes on while the pointer
    /// only trembles. @param way  of the pointer [pixels]
    yieldTo(way: number): void {
        if (!this.ticking || way > kTremble) this.stop();
    }
}
