// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Threshold, shared by all clients. One command is under way at a time; of the requests since, only
// the newest is sent. On request the tissue's air follows it: what looks empty counts as air.

import type { Polarity } from '../net/protocol.ts';
import { hasMaterials } from '../state/state.ts';
import type { Scene } from './scene.ts';

export interface Threshold {
    readonly iso_hu?: number;
    readonly polarity?: Polarity;
}

const kAirMs = 400; // after the threshold's last change

export class ThresholdTool {
    private wish: Threshold | undefined;
    private sent: number | undefined;
    private busy = false;
    private airWaits = 0;

    constructor(private readonly scene: Scene) {}

    ask(wish: Threshold): void {
        this.wish = { ...this.wish, ...wish };
        if (!this.busy) void this.send();
    }

    /// Ties the tissue's air to the threshold, or leaves it as it is.
    tieAir(on: boolean): void {
        this.scene.store.set({ display: { airFollows: on } });
        if (on) this.setAir();
    }

    private setAir(): void {
        const { state } = this.scene.store;
        const { shared, display } = state;
        if (!display.airFollows || !shared?.materials || shared.polarity === 'falling') return;
        if (!hasMaterials(state)) return;
        const { air_enabled, air_threshold_hu } = shared.materials;
        if (air_enabled && air_threshold_hu === shared.iso_hu) return;
        const air = { air_enabled: true, air_threshold_hu: shared.iso_hu };
        void this.scene.ask({ do: 'materials', ...air });
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
        clearTimeout(this.airWaits);
        this.airWaits = setTimeout(() => this.setAir(), kAirMs) as unknown as number;
    }
}
