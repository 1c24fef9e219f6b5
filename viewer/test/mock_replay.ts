// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A recorded session of the mock: pushes with their times. It plays in steps of a timer, and is
// brought to an earlier time by repeating the pushes from the start.

import type { ReplayNews } from '../src/net/company.ts';
import type { Vec3 } from '../src/maths/vec.ts';
import type { MockScene } from './mock_scene.ts';

export interface RecordedPush {
    readonly at_ms: number;
    readonly point: Vec3;
    readonly push: Vec3;
    readonly radius: number;
}

const kTickMs = 50;

export class MockReplay {
    private at = 0;
    private speed = 1;
    private playing = false;
    private done = 0; // pushes that are carried out
    private readonly timer = setInterval(() => this.advance(), kTickMs);

    constructor(
        private readonly scene: MockScene,
        private readonly pushes: readonly RecordedPush[],
        private readonly length: number,
        private readonly tell: () => void,
    ) {}

    stop(): void {
        clearInterval(this.timer);
    }

    marks(): object {
        const marks = this.pushes.map(({ at_ms }) => ({ at_ms, client: 1, do: 'push' }));
        return { t: 'replay_marks', marks };
    }

    news(): ReplayNews {
        const { at, length, speed, playing } = this;
        return {
            t: 'replay',
            at_ms: Math.round(at),
            length_ms: length,
            speed,
            playing,
            seeking: false,
        };
    }

    take(wish: { playing?: boolean; speed?: number; at_ms?: number }): void {
        this.speed = wish.speed ?? this.speed;
        if (wish.at_ms !== undefined) this.goTo(wish.at_ms);
        if (wish.playing && this.at >= this.length) this.goTo(0);
        this.playing = wish.playing ?? this.playing;
        this.tell();
    }

    private advance(): void {
        if (!this.playing) return;
        this.goTo(this.at + kTickMs * this.speed);
        this.playing = this.at < this.length;
        this.tell();
    }

    /// Brings the scene to a time: with all pushes before it, at the end with all.
    private goTo(at: number): void {
        this.at = Math.min(at, this.length);
        const isEnd = this.at === this.length;
        const due = this.pushes.filter(({ at_ms }) => isEnd || at_ms < this.at).length;
        if (due < this.done) {
            this.scene.reset();
            this.done = 0;
        }
        for (; this.done < due; ++this.done) {
            const { point, push, radius } = this.pushes[this.done]!;
            this.scene.push(point, push, radius);
        }
    }
}
