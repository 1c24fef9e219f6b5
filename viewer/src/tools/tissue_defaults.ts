// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// How ChainMail behaves in a fresh scan: with rounded limits, and springing back to rest. The
// server starts with the limits of a box and without relaxation; a page that is alone with an
// untouched scan, or the first of several, sets this browser's wish once.

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

const modelOf = ({ tissue }: SharedState): string => tissue?.model ?? 'chainmail';

export class TissueDefaults {
    private scan: number | undefined; ///< whose state has arrived
    private model = '';

    constructor(
        private readonly scene: Scene,
        private readonly memory: Memory,
    ) {}

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

    /// Takes a state of the present scan; the first one of ChainMail gets the wish.
    take(shared: SharedState): void {
        const { volume } = this.scene.store.state.scan;
        const model = modelOf(shared);
        const isNew = volume?.id !== this.scan || model !== this.model;
        this.scan = volume?.id;
        this.model = model;
        if (isNew && model === 'chainmail') this.apply(shared);
    }

    private apply({ undo, redo, clients, materials, relaxing }: SharedState): void {
        const { link } = this.scene.store.state;
        const controlling = clients.filter(({ role }) => role === 'control');
        const isFirst = controlling.every(({ client }) => client >= link.client);
        if (undo.steps || redo.steps || link.role === 'view' || !isFirst) return;
        const { limits, springsBack } = this.wish;
        if (materials.limits !== limits)
            void this.scene.connection.ask({ do: kDefaultsStep, limits });
        if (relaxing !== springsBack)
            void this.scene.connection.ask({ do: 'relax', on: springsBack });
    }
}
