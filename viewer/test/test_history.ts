// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { SharedState } from '../src/net/protocol.ts';
import { History } from '../src/state/history.ts';
import { initialState } from '../src/state/state.ts';
import { Store } from '../src/state/store.ts';

/// History with a server that only counts steps.
function setUp(): { store: Store; history: History; pushes: () => void; log: string[] } {
    const store = new Store(initialState());
    const log: string[] = [];
    let undo = 0;
    let redo = 0;
    const tell = (): void =>
        store.set({
            shared: {
                undo: { steps: undo, next: undo ? 'push' : '' },
                redo: { steps: redo, next: redo ? 'push' : '' },
            } as SharedState,
        });
    let time = 0;
    const history = new History(
        store,
        async (step) => {
            log.push(step);
            undo += step === 'undo' ? -1 : 1;
            redo += step === 'undo' ? 1 : -1;
            tell();
        },
        () => (time += 1000),
    );
    const pushes = (): void => {
        ++undo;
        redo = 0;
        tell();
    };
    tell();
    return { store, history, pushes, log };
}

test('undo takes back window, push and camera in the order in which they were done', async () => {
    const { store, history, pushes, log } = setUp();
    history.step('window', () => store.set({ sections: { window: 100 } }));
    pushes();
    history.step('level', () => store.set({ sections: { level: 7 } }));
    history.step('view', () => store.set({ view: { fieldOfView: 44 } }));
    assert.equal(history.names().undo, 'view');
    await history.undo();
    assert.equal(store.state.view.fieldOfView, 80);
    await history.undo();
    assert.equal(store.state.sections.level, -200);
    assert.deepEqual(log, []);
    await history.undo();
    assert.deepEqual(log, ['undo']);
    assert.equal(store.state.sections.window, 100);
    await history.undo();
    assert.equal(store.state.sections.window, 1500);
    for (let i = 0; i < 4; ++i) await history.redo();
    assert.deepEqual(log, ['undo', 'redo']);
    assert.equal(store.state.sections.window, 100);
    assert.equal(store.state.sections.level, 7);
    assert.equal(store.state.view.fieldOfView, 44);
    assert.equal(history.names().redo, '');
});

test('a change without effect is no step, and a new step clears the steps to redo', async () => {
    const { store, history } = setUp();
    history.step('nothing', () => store.set({ sections: { window: store.state.sections.window } }));
    assert.equal(history.names().undo, '');
    history.step('window', () => store.set({ sections: { window: 10 } }));
    await history.undo();
    history.step('level', () => store.set({ sections: { level: 1 } }));
    assert.equal(history.names().redo, '');
    await history.redo();
    assert.equal(store.state.sections.window, 1500);
});

test('flying and looking around at the same time are one step', async () => {
    const { store, history } = setUp();
    history.begin();
    store.set({ view: { camera: { eye: [1, 0, 0], look: [0, 1, 0], up: [0, 0, 1] } } });
    history.begin();
    store.set({ view: { camera: { eye: [1, 0, 0], look: [1, 0, 0], up: [0, 0, 1] } } });
    history.end('look');
    store.set({ view: { camera: { eye: [2, 0, 0], look: [1, 0, 0], up: [0, 0, 1] } } });
    history.end('flight');
    assert.equal(history.names().undo, 'flight');
    await history.undo();
    assert.deepEqual(store.state.view.camera.eye, [0, 0, 0]);
    assert.equal(history.names().undo, '');
});

/// Server with named steps, as it is after pushes of tissue that springs back.
function withSteps(...names: string[]): { history: History; log: string[]; empty: () => void } {
    const store = new Store(initialState());
    const [done, undone]: string[][] = [names, []];
    const log: string[] = [];
    let lastIsEmpty = false;
    const last = (list: readonly string[]) => ({ steps: list.length, next: list.at(-1) ?? '' });
    const tell = (): void =>
        store.set({
            shared: {
                undo: last(done),
                redo: last(undone),
                relaxing: true,
                materials: { limits: 'rounded' },
            } as SharedState,
        });
    const history = new History(store, async (step) => {
        if (step === 'undo' && lastIsEmpty) done.pop();
        lastIsEmpty = false;
        const name = (step === 'undo' ? done : undone).pop()!;
        (step === 'undo' ? undone : done).push(name);
        log.push(`${step} ${name}`);
        tell();
    });
    tell();
    const empty = (): void => {
        lastIsEmpty = true;
    };
    return { history, log, empty };
}

test('a push and its springing back are undone and redone together', async () => {
    const { history, log } = withSteps('push', 'relax', 'push', 'relax');
    await history.undo();
    assert.deepEqual(log.splice(0), ['undo relax', 'undo push']);
    await history.redo();
    assert.deepEqual(log.splice(0), ['redo push', 'redo relax']);
});

test('the defaults of a fresh scan are no step of the user', async () => {
    const { history, log } = withSteps('materials', 'push', 'relax');
    assert.equal(history.names().undo, 'relax');
    await history.undo();
    assert.deepEqual(log.splice(0), ['undo relax', 'undo push']);
    assert.equal(history.names().undo, '');
    await history.undo();
    assert.deepEqual(log, []);
});

test('settings of the volume rendering and of slabs are steps', async () => {
    const { store, history } = setUp();
    history.step('opacity', () => store.set({ rendering: { opacity: 3 } }));
    history.step('slab', () => store.set({ sections: { slab: 10, projection: 'mean' } }));
    await history.undo();
    assert.equal(store.state.sections.slab, 0);
    assert.equal(store.state.sections.projection, 'maximum');
    assert.equal(store.state.rendering.opacity, 3);
    await history.undo();
    assert.equal(store.state.rendering.opacity, 1);
    await history.redo();
    assert.equal(store.state.rendering.opacity, 3);
});

test('defaults that are undone because the push before had no effect come back', async () => {
    const { history, log, empty } = withSteps('materials', 'push');
    empty();
    await history.undo();
    assert.deepEqual(log, ['undo materials', 'redo materials']);
});
