// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Threshold, shared by all clients. One command is under way at a time; of the requests since, only
// the newest is sent.

import type { Polarity } from '../net/protocol.ts';
import type { Scene } from './scene.ts';

export interface Threshold {
    readonly iso_hu?: number;
    readonly polarity?: Polarity;
}

export class ThresholdTool {
    private wish: Threshold | undefined;
    private sent: number | undefined;
    private busy = false;

    constructor(private readonly scene: Scene) {}

    ask(wish: Threshold): void {
        this.wish = { ...this.wish, ...wish };
        if (!this.busy) void this.send();
    }

    /// Last requested threshold, else the server's [HU].
    get wanted(): number {
        return this.wish?.iso_hu ?? this.sent ?? this.scene.store.state.shared?.iso_hu ?? -500;
    }

    private async send(): Promise<void> {
        this.busy = true;
        while (this.wish) {
            const { wish } = this;
            this.wish = undefined;
            this.sent = wish.iso_hu;
            await this.scene.ask({ do: 'iso', ...wish });
        }
        this.sent = undefined;
        this.busy = false;
    }
}
