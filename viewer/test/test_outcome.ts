// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Outcomes of commands in words, the wall that a scoop follows, the window of a scan, and fingers:
// without a browser.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { autoWindow } from '../src/maths/auto_window.ts';
import type { Grid } from '../src/maths/grid.ts';
import { halfOfFloat } from '../src/maths/half.ts';
import { norm, sub, type Vec3 } from '../src/maths/vec.ts';
import { VolumeData } from '../src/maths/volume.ts';
import type { Done, SharedState } from '../src/net/protocol.ts';
import { initialState, type State } from '../src/state/state.ts';
import { CarveWall } from '../src/tools/carve_wall.ts';
import { cutCrossings } from '../src/tools/cuts.ts';
import { Fingers } from '../src/tools/fingers.ts';
import { outcomeOf, wordsOf } from '../src/tools/outcome.ts';

const kGrid: Grid = {
    size: [40, 40, 40],
    spacing: [1, 1, 1],
    origin: [0, 0, 0],
    direction: [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
    ],
};

function volumeOf(value: (i: number, j: number, k: number) => number): VolumeData {
    const halves = new Uint16Array(40 ** 3);
    for (let n = 0; n < halves.length; ++n)
        halves[n] = halfOfFloat(value(n % 40, Math.floor(n / 40) % 40, Math.floor(n / 1600)));
    return new VolumeData(kGrid, halves);
}

const shared = { iso_hu: -500, polarity: 'rising', materials: { bone_threshold_hu: 300 } };
const state: State = { ...initialState(), shared: shared as SharedState };
const done = (more: Partial<Done>): Done => ({ t: 'done', id: 1, do: 'push', step: 1, ...more });

test('the bone that stops a tool is where the server says', () => {
    const motion = { from: [20, 20, 20] as Vec3, by: [2, 0, 0] as Vec3, radius: 4 };
    const limited = { status: 'limited', limited_by: 'bone', grabbed_elements: 9 } as const;
    const words = outcomeOf(done({ ...limited, bone: [20, 42, 20] }), state, motion)!;
    assert.equal(words.text, 'stopped by bone, 18 mm away');
    assert.ok(words.isStopped);
    assert.deepEqual(words.obstacle, [20, 42, 20]);
    const unsaid = outcomeOf(done(limited), state, motion)!;
    assert.equal(unsaid.text, 'stopped by bone');
    assert.equal(unsaid.obstacle, null);
});

test('a refusal has words for a person', () => {
    const clients = [{ client: 3, name: 'Anna', role: 'control' as const }];
    const held: State = { ...state, shared: { ...shared, holder: 3, clients } as SharedState };
    const words = (code: string, verb = 'grab', message = 'x'): string =>
        wordsOf({ t: 'error', id: 1, do: verb, code, message }, held);
    assert.equal(words('held_by_other'), 'Anna holds the tissue');
    assert.equal(words('not_holding', 'drag'), '');
    assert.equal(words('no_tissue', 'push'), 'no tissue here');
    assert.equal(words('limit', 'push', 'too large'), 'too large');
});

test('outcomes are words of the clinic, and there is none where all went well', () => {
    const text = (more: Partial<Done>): string | undefined =>
        outcomeOf(done(more), state, undefined)?.text;
    assert.equal(text({ status: 'applied' }), undefined);
    assert.equal(text({}), undefined);
    assert.equal(text({ status: 'rejected', limited_by: 'bone' }), 'stopped by bone');
    assert.equal(
        text({ status: 'limited', limited_by: 'movement' }),
        'stopped: this tissue gives no more',
    );
    assert.equal(text({ do: 'grab', grabbed_elements: 0 }), 'no tissue here');
    assert.equal(text({ do: 'push', grabbed_elements: 0 }), undefined, 'a probe in the lumen');
    assert.equal(text({ do: 'cut', cut_links: 94 }), 'cut: 94 links');
});

test('a scoop follows the wall as it was: carving does not deepen it', () => {
    const wall = (i: number): number => (i >= 20 ? 40 : -1000);
    const volume = volumeOf(wall);
    const look = { eye: [5, 20, 20] as Vec3, look: [1, 0, 0] as Vec3, up: [0, 0, 1] as Vec3 };
    const seen: State = { ...state, view: { ...state.view, camera: look, barrel: 0 } };
    const spot = { view: 'endoscope' as const, x: 100, y: 100, width: 200, height: 200 };
    const scoop = new CarveWall(volume, seen, spot, [20, 20, 20]);
    const first = scoop.at(seen, spot)!;
    assert.ok(Math.abs(first[0] - 19.5) < 0.6, `${first}`);
    // A shaft through the wall under the pointer.
    const size: Vec3 = [20, 9, 9];
    const air = new Uint16Array(size[0] * size[1] * size[2]).fill(halfOfFloat(-1000));
    volume.patch({ begin: [20, 16, 16], end: [40, 25, 25] }, air);
    assert.deepEqual(scoop.at(seen, spot), first);
    scoop.depth = 3;
    assert.ok(Math.abs(scoop.at(seen, spot)![0] - first[0] - 3) < 1e-9);
});

test('a cut crosses a section in a line as long as its depth', () => {
    const line: Vec3[] = [
        [10, 5, 10],
        [10, 5, 20],
        [10, 5, 30],
    ];
    const cut = { line, depth: [0, 8, 0] as Vec3, steps: 1 };
    assert.deepEqual(cutCrossings(cut, [0, 0, 25], [0, 0, 1]), [
        [
            [10, 5, 25],
            [10, 13, 25],
        ],
    ]);
    assert.deepEqual(cutCrossings(cut, [0, 0, 35], [0, 0, 1]), []);
});

test('in a section a scoop stays in its plane, at its depth', () => {
    const volume = volumeOf(() => 40);
    const at: State = { ...state, sections: { ...state.sections, cursor: [20, 20, 12] } };
    const spot = { view: 'axial' as const, x: 100, y: 100, width: 200, height: 200 };
    const scoop = new CarveWall(volume, at, spot, [20, 20, 12]);
    const moved: State = { ...at, sections: { ...at.sections, cursor: [20, 20, 30] } };
    assert.ok(Math.abs(scoop.at(moved, spot)![2] - 12) < 1e-9);
    scoop.depth = 2;
    assert.ok(Math.abs(scoop.at(moved, spot)![2] - 14) < 1e-9);
});

test('the window of a scan holds its values but not the padding', () => {
    const { window, level } = autoWindow(volumeOf((i, j) => (i < 20 ? 0 : 100 + 10 * j)));
    assert.ok(window > 330 && window < 400, `${window}`);
    assert.ok(Math.abs(level - 295) < 15, `${level}`);
    assert.ok(autoWindow(volumeOf(() => 7)).window >= 1);
});

test('two fingers give a factor and a motion of their middle, one gives none', () => {
    const fingers = new Fingers();
    const at = (pointerId: number, clientX: number, clientY: number): PointerEvent =>
        ({ pointerId, clientX, clientY }) as PointerEvent;
    assert.equal(fingers.down(at(1, 0, 0)), false);
    assert.equal(fingers.move(at(1, 5, 0)), undefined);
    assert.equal(fingers.down(at(2, 105, 0)), true);
    const pinch = fingers.move(at(2, 205, 40))!;
    assert.ok(Math.abs(pinch.factor - norm(sub([205, 40, 0], [5, 0, 0])) / 100) < 1e-9);
    assert.deepEqual([pinch.dx, pinch.dy, pinch.middle.x], [50, 20, 105]);
    assert.equal(fingers.up(at(1, 5, 0)), false);
    assert.ok(fingers.pinch, 'the finger that is left moves nothing');
    assert.equal(fingers.up(at(2, 205, 40)), true);
    assert.ok(!fingers.pinch);
});
