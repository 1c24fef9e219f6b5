// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { clearance, flown, speedFor, wouldTouch } from '../src/maths/flight.ts';
import { type Grid, voxelFromWorld } from '../src/maths/grid.ts';
import { halfOfFloat } from '../src/maths/half.ts';
import { inTissue } from '../src/maths/rays.ts';
import { along, norm, normalized, sub, type Vec3 } from '../src/maths/vec.ts';
import { VolumeData } from '../src/maths/volume.ts';
import { initialState } from '../src/state/state.ts';
import { Store } from '../src/state/store.ts';
import { Endoscope } from '../src/tools/endoscope.ts';
import { randomVector } from './fields.ts';
import { kGrid, kTubeRadius, MockScene, tubeCentre } from './mock_scene.ts';
import { between } from './random.ts';

const kSurface = { iso: -500, rising: true };
const tube = (): VolumeData => new VolumeData(kGrid, new MockScene().halves.slice());

test('free flight stays in the lumen for 10,000 random steps', () => {
    const volume = tube();
    let place = tubeCentre(-20);
    let heading = randomVector(1);
    let way = 0;
    for (let i = 0; i < 10_000; ++i) {
        if (i % 25 === 0) heading = normalized(randomVector(1));
        const next = flown(
            volume,
            place,
            heading.map((x) => x * between(0, 3)) as never,
            2.5,
            kSurface,
        );
        way += norm(sub(next, place));
        place = next;
        const value = volume.sample(voxelFromWorld(volume.grid, place));
        assert.ok(!inTissue(value, kSurface), `step ${i}: ${value} HU at ${place}`);
        const off = norm(sub(place, tubeCentre(place[2])));
        // The tip's sphere keeps off the wall, but is tested at 26 points only.
        if (Math.abs(place[2]) < 40) assert.ok(off < kTubeRadius - 1.5, `step ${i}: ${off} mm`);
    }
    assert.ok(way > 500, `it only flew ${way} mm`);
});

test('a tip that is stuck in tissue gets out, but not deeper', () => {
    const volume = tube();
    const centre = tubeCentre(0);
    const stuck = [centre[0] + kTubeRadius, centre[1], 0] as const;
    const deeper = flown(volume, stuck, [6, 0, 0], 2.5, kSurface);
    assert.ok(deeper[0] - stuck[0] < 0.5, `${deeper[0] - stuck[0]} mm deeper`);
    const out = flown(volume, stuck, [-8, 0, 0], 2.5, kSurface);
    assert.ok(stuck[0] - out[0] > 7, `${stuck[0] - out[0]} mm back`);
});

test('the clearance around a point is the distance to the wall', () => {
    const volume = tube();
    for (const off of [0, 2, 4, 6]) {
        const [x, y, z] = tubeCentre(0);
        const room = clearance(volume, [x + off, y, z], kSurface, 50);
        assert.ok(Math.abs(room - (kTubeRadius + 0.7 - off)) < 1, `${off}: ${room}`);
    }
});

/// Volume of air with sheets of tissue across x, one voxel thick.
function sheets(spacing: number): VolumeData {
    const grid: Grid = {
        size: [60, 40, 40],
        spacing: [spacing, spacing, spacing],
        origin: [0, 0, 0],
        direction: [
            [1, 0, 0],
            [0, 1, 0],
            [0, 0, 1],
        ],
    };
    const halves = new Uint16Array(60 * 40 * 40);
    for (let n = 0; n < halves.length; ++n) halves[n] = halfOfFloat(n % 20 === 10 ? 40 : -1000);
    return new VolumeData(grid, halves);
}

/// Tests whether a segment passes through tissue.
function crosses(volume: VolumeData, from: Vec3, to: Vec3): boolean {
    for (let n = 0; n <= 200; ++n) {
        const place = along(from, n / 200, sub(to, from));
        if (inTissue(volume.sample(voxelFromWorld(volume.grid, place)), kSurface)) return true;
    }
    return false;
}

test('no tip leaps over a sheet of one voxel, whether it stops or pushes', () => {
    let stopped = 0;
    let touched = 0;
    for (let n = 0; n < 3000; ++n) {
        const spacing = between(0.05, 1);
        const volume = sheets(spacing);
        const radius = between(0.1, 8);
        const from = [59, 39, 39].map((last) => between(0.1, 0.9) * last * spacing) as never;
        if (inTissue(volume.sample(voxelFromWorld(volume.grid, from)), kSurface)) continue;
        // Longest motion of a slow page in one frame, at the highest speed.
        const way = 0.4 * speedFor(clearance(volume, from, kSurface, 60));
        const motion = normalized(randomVector(1)).map((x) => way * x) as never;
        const end = flown(volume, from, motion, radius, kSurface);
        assert.ok(!crosses(volume, from, end), `stops: ${from} to ${end}, ${radius} mm`);
        const to = along(from, 1, motion);
        if (norm(sub(end, to)) > 1e-9) ++stopped;
        if (wouldTouch(volume, from, to, radius, kSurface)) ++touched;
        else assert.ok(!crosses(volume, from, to), `pushes: ${from} to ${to}, ${radius} mm`);
    }
    assert.ok(stopped > 100 && touched > 100, `${stopped} stopped, ${touched} touched`);
});

test('an eye whose dent springs back returns on its own side of the wall', () => {
    const pitted = (depth: number): VolumeData => {
        // Two rooms of air beside a wall at x −3…3 mm, with a pit into the wall from the left.
        const halves = new Uint16Array(40 ** 3);
        for (let n = 0; n < halves.length; ++n) {
            const [x, y, z] = [n % 40, Math.floor(n / 40) % 40, Math.floor(n / 1600)].map(
                (i) => i - 19.5,
            ) as never as Vec3;
            const inPit = x < depth && Math.hypot(y, z) < 4;
            const isWall = Math.abs(x) < 3 && !inPit;
            halves[n] = halfOfFloat(isWall ? 40 : -1000);
        }
        const size = [40, 40, 40] as const;
        const origin = [-19.5, -19.5, -19.5] as const;
        return new VolumeData({ ...kGrid, size, origin, spacing: [1, 1, 1] }, halves);
    };
    const store = new Store(initialState());
    const scene = {
        store,
        volume: pitted(2),
        surface: kSurface,
        isInTissue: (p: Vec3): boolean => {
            const { volume } = scene;
            return inTissue(volume.sample(voxelFromWorld(volume.grid, p)), kSurface);
        },
        warn: (text: string) => assert.fail(text),
    };
    store.set({ scan: { loaded: 1 }, flight: { wall: 'stop', tip: 1 } });
    const endoscope = new Endoscope(scene as never);
    const goTo = (eye: Vec3): void =>
        store.set({ view: { camera: { ...store.state.view.camera, eye } } });
    for (let x = -12; x <= 1; ++x) goTo([x, 0, 0]);
    assert.equal(endoscope.holdingRadius, 1, 'it holds the pit that it pressed');
    scene.volume = pitted(-3);
    endoscope.keepEyeFree();
    const { eye } = store.state.view.camera;
    assert.ok(eye[0] < -3 && eye[0] > -7, `${eye}`);
    assert.equal(endoscope.holdingRadius, 0, 'an eye that was carried aside holds nothing');
    scene.volume = pitted(2);
    endoscope.keepEyeFree();
    assert.deepEqual(store.state.view.camera.eye, [1, 0, 0], 'it returns with the pit');
    assert.equal(endoscope.holdingRadius, 1);
});
