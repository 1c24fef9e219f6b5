// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A recorded session that is watched: its time is the server's, and shared by all clients. One jump
// is under way at a time; of the requests since, only the newest is sent.

import type { CompanyNews, ReplayMark } from '../net/company.ts';
import type { Replay } from '../state/company.ts';
import type { Scene } from './scene.ts';

const kLeewayMs = 1000; // of the real time: a mark that has just passed is not the previous one

/// Time of the next mark (way 1) or the previous one (−1); undefined: there is none. Times are
/// rounded to milliseconds.
export function markBeside(
    marks: readonly ReplayMark[],
    at: number,
    way: 1 | -1,
    leeway: number,
): number | undefined {
    const times = marks.map((mark) => mark.at_ms);
    return way > 0
        ? times.find((time) => time > at + 0.5)
        : times.filter((time) => time < at - 0.5 - leeway).pop();
}

export class ReplayTool {
    private wish: number | undefined;
    private busy = false;
    private seeking = false; // the server

    constructor(private readonly scene: Scene) {}

    private get replay(): Replay {
        return this.scene.store.state.replay;
    }

    take(news: Exclude<CompanyNews, { t: 'camera' }>): void {
        const { store } = this.scene;
        if (news.t === 'replay_marks') {
            store.set({ replay: { marks: news.marks } });
            return;
        }
        this.seeking = news.seeking;
        store.set({
            replay: {
                at: this.wish ?? news.at_ms, // the slider stays where the user has put it
                length: news.length_ms,
                speed: news.speed,
                playing: news.playing,
                seeking: news.seeking || this.wish !== undefined,
                failure: news.failure ?? '',
            },
        });
    }

    /// Plays, or pauses.
    toggle(): void {
        const { controls, playing } = this.replay;
        if (!controls) this.scene.warn('only clients that control the session set its time');
        else void this.scene.connection.ask({ do: 'replay', playing: !playing });
    }

    setSpeed(speed: number): void {
        if (this.replay.controls) void this.scene.connection.ask({ do: 'replay', speed });
    }

    /// Goes to a time [ms].
    jump(at: number): void {
        const { controls, length } = this.replay;
        if (!controls) return;
        this.wish = Math.min(Math.max(at, 0), length);
        this.scene.store.set({ replay: { at: this.wish, seeking: true } });
        if (!this.busy) void this.send();
    }

    /// Goes to the next mark, or to the previous one; the start counts as one.
    step(way: 1 | -1): void {
        const { marks, at, playing, speed, length } = this.replay;
        const leeway = playing ? kLeewayMs * speed : 0;
        const to = markBeside(marks, at, way, leeway) ?? (way > 0 ? length : 0);
        this.jump(to);
    }

    private async send(): Promise<void> {
        this.busy = true;
        while (this.wish !== undefined) {
            const at_ms = this.wish;
            await this.scene.connection.ask({ do: 'replay', at_ms });
            if (this.wish === at_ms) this.wish = undefined;
        }
        this.busy = false;
        this.scene.store.set({ replay: { seeking: this.seeking } });
    }
}
