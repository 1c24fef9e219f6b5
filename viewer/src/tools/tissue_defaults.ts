// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// How ChainMail behaves in a fresh scan: with rounded limits, and springing back to rest. The
// server starts with the limits of a box and without relaxation; a page that is alone with an
// untouched scan, or the first of several, sets this browser's wish.

import type { Memory } from '../net/connection.ts';
import type { SharedState } from '../net/protocol.ts';
import type { Materials } from '../net/settings.ts';
import { kDefaultsStep } from '../state/history.ts';
import type { Scene } from './scene.ts';

export interface TissueWish {
    readonly limits: Materials['limits'];
    readonly springsBack: boolean;
}

const kKey = 'pliant.tissue';
const kUsual: TissueWish = { limits: 'rounded', springsBack: true };

/// Tests whether nothing was done to the tissue.
const isFresh = ({ undo, redo, tissue }: SharedState): boolean =>
    !undo.steps && !redo.steps && (tissue?.model ?? 'chainmail') === 'chainmail';

export class TissueDefaults {
    private setFor: number | undefined; ///< id of the scan whose defaults were set

    constructor(
        private readonly scene: Scene,
        private readonly memory: Memory,
    ) {
        scene.store.watch(
            ({ shared, link, scan }) => [shared, link.status, scan.volume],
            () => this.apply(),
        );
    }

    get wish(): TissueWish {
        try {
            return { ...kUsual, ...JSON.parse(this.memory.getItem(kKey) ?? '{}') };
        } catch {
            return kUsual; // not written by this page
        }
    }

    /// Keeps a wish for this and later scans.
    keep(wish: Partial<TissueWish>): void {
        this.memory.setItem(kKey, JSON.stringify({ ...this.wish, ...wish }));
    }

    private apply(): void {
        const { shared, link, scan } = this.scene.store.state;
        if (!shared || !scan.volume || link.status !== 'open' || link.role === 'view') return;
        if ((shared.tissue?.model ?? 'chainmail') !== 'chainmail') this.setFor = undefined;
        if (scan.volume.id === this.setFor) return;
        const first = Math.min(
            ...shared.clients.filter((c) => c.role === 'control').map((c) => c.client),
        );
        if (!isFresh(shared) || first < link.client) return;
        const { limits, springsBack } = this.wish;
        if (shared.materials.limits === limits && shared.relaxing === springsBack) return;
        this.setFor = scan.volume.id;
        if (shared.materials.limits !== limits)
            void this.scene.connection.ask({ do: kDefaultsStep, limits });
        if (shared.relaxing !== springsBack)
            void this.scene.connection.ask({ do: 'relax', on: springsBack });
    }
}
