// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Defaults of the tissue: sent once for each fresh scan, by the first client that controls it.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Command, SharedState, VolumeInfo } from '../src/net/protocol.ts';
import { initialState } from '../src/state/state.ts';
import { Store } from '../src/state/store.ts';
import type { Scene } from '../src/tools/scene.ts';
import { TissueDefaults } from '../src/tools/tissue_defaults.ts';

function setUp(kept: string | null = null): {
    defaults: TissueDefaults;
    sent: Command[];
    open: (id: number) => void;
} {
    const store = new Store(initialState());
    store.set({ link: { status: 'open', role: 'control', client: 2 } });
    const sent: Command[] = [];
    const connection = { ask: (command: Command) => void sent.push(command) };
    let memory = kept;
    const defaults = new TissueDefaults({ store, connection } as unknown as Scene, {
        getItem: () => memory,
        setItem: (_, text) => {
            memory = text;
        },
    });
    const open = (id: number): void => store.set({ scan: { volume: { id } as VolumeInfo } });
    return { defaults, sent, open };
}

const state = (more: object = {}): SharedState =>
    ({
        undo: { steps: 0, next: '' },
        redo: { steps: 0, next: '' },
        materials: { limits: 'box' },
        relaxing: false,
        clients: [{ client: 2, name: '', role: 'control' }],
        ...more,
    }) as unknown as SharedState;

const kWished: Command[] = [
    { do: 'materials', limits: 'rounded' },
    { do: 'relax', on: true },
];

test('a fresh scan gets the defaults once; what the user does later stays', () => {
    const { defaults, sent, open } = setUp();
    open(1);
    defaults.take(state());
    assert.deepEqual(sent.splice(0), kWished);
    defaults.take(state()); // before the answers
    defaults.take(state({ relaxing: true }));
    defaults.take(state({ materials: { limits: 'rounded' } }));
    assert.deepEqual(sent, []);
    open(2);
    defaults.take(state());
    assert.deepEqual(sent.splice(0), kWished);
    defaults.take(state({ tissue: { model: 'springs' } }));
    assert.deepEqual(sent, []);
    defaults.take(state({ tissue: { model: 'chainmail' } }));
    assert.deepEqual(sent, kWished);
});

test('a scan that was worked on, or that another client opened, is left alone', () => {
    for (const more of [
        { undo: { steps: 1, next: 'push' } },
        { redo: { steps: 1, next: 'push' } },
        { clients: [1, 2].map((client) => ({ client, name: '', role: 'control' })) },
        { tissue: { model: 'vessel' } },
    ]) {
        const { defaults, sent, open } = setUp();
        open(1);
        defaults.take(state(more));
        assert.deepEqual(sent, [], JSON.stringify(more));
    }
});

test('the wish is kept, and a broken one is the usual one', () => {
    const { defaults, sent, open } = setUp('{');
    assert.deepEqual(defaults.wish, { limits: 'rounded', springsBack: true });
    defaults.keep({ limits: 'box' });
    open(1);
    defaults.take(state());
    assert.deepEqual(sent, [{ do: 'relax', on: true }]);
});
