// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Vessels: frames, keys and sticks, curves of catheters, cameras.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { voxelFromWorld } from '../src/maths/grid.ts';
import { halfOfFloat } from '../src/maths/half.ts';
import { firstHit } from '../src/maths/rays.ts';
import { add, along, cross, dot, mul, norm, normalized, sub, type Vec3 } from '../src/maths/vec.ts';
import { VolumeData } from '../src/maths/volume.ts';
import { decodeFrame } from '../src/net/protocol.ts';
import { Vessel } from '../src/net/vessel.ts';
import { chainParts, crossings } from '../src/panels/chain_marks.ts';
import { initialState, offersVessel } from '../src/state/state.ts';
import { Store } from '../src/state/store.ts';
import { sumOf, wishOfKeys, wishOfPad } from '../src/tools/catheter_hand.ts';
import type { Scene } from '../src/tools/scene.ts';
import { Subscriptions } from '../src/tools/subscriptions.ts';
import {
    catheterRows,
    drawnCurve,
    gapAround,
    kGroup,
    kMaxPoints,
    smoothed,
} from '../src/views/catheter_texture.ts';
import { planesOf, planeUnder } from '../src/views/planes.ts';
import { projectionOf, usualWater, waterAlong } from '../src/views/fluoroscopy.ts';
import { distanceToSegment } from '../src/views/instruments.ts';
import { behindTip, onTip, outsideOf, principalAxes } from '../src/views/vessel_camera.ts';
import { kGrid, MockScene, tubeCentre } from './mock_scene.ts';
import { between, random, whole } from './random.ts';

function frameOf(type: number, payload: number, fill: (view: DataView) => void): ArrayBuffer {
    const bytes = new Uint8Array(32 + payload);
    const view = new DataView(bytes.buffer);
    bytes.set(new TextEncoder().encode('PLNT'));
    view.setUint8(4, type);
    view.setUint32(12, 3, true);
    view.setUint32(28, payload, true);
    fill(view);
    return bytes.buffer;
}

function surfaceFrame(rest: readonly number[], corners: readonly number[]): ArrayBuffer {
    return frameOf(3, 8 + 4 * rest.length + 4 * corners.length, (view) => {
        view.setUint32(32, rest.length / 3, true);
        view.setUint32(36, corners.length / 3, true);
        rest.forEach((x, i) => view.setFloat32(40 + 4 * i, x, true));
        const at = 40 + 4 * rest.length;
        corners.forEach((n, i) => view.setUint32(at + 4 * i, n, true));
    });
}

function vesselFrame(
    points: readonly number[],
    runs: readonly { first: number; by: readonly number[] }[],
): ArrayBuffer {
    const moved = runs.flatMap((run) => run.by);
    const size = 12 + 4 * points.length + 8 * runs.length + 2 * moved.length;
    return frameOf(4, size, (view) => {
        view.setFloat32(32, 0.75, true);
        view.setUint32(36, points.length / 3, true);
        view.setUint32(40, runs.length, true);
        let at = 44;
        for (const x of points) view.setFloat32((at += 4) - 4, x, true);
        for (const { first, by } of runs) {
            view.setUint32((at += 4) - 4, first, true);
            view.setUint32((at += 4) - 4, by.length / 3, true);
        }
        for (const x of moved) view.setUint16((at += 2) - 2, halfOfFloat(x), true);
    });
}

test('a catheter that appears with another tissue is asked for, once', () => {
    const store = new Store(initialState());
    const sent: unknown[] = [];
    const connection = { ask: (command: unknown) => void sent.push(command) };
    new Subscriptions({ store, connection } as unknown as Scene);
    const show = (shared: object): void => store.set({ shared: shared as never });
    store.set({ link: { features: ['vessel'] } });
    show({ tissue: { model: 'chainmail' } });
    assert.ok(!offersVessel(store.state.shared));
    show({ tissue: { model: 'own' }, vessel: {} });
    show({ tissue: { model: 'own' }, vessel: {} });
    assert.ok(offersVessel(store.state.shared));
    assert.deepEqual(sent.splice(0), [{ do: 'vessel', on: true }]);
    // The scene of a vessel has it whatever its tissue, and the welcome asks for it.
    show({ tissue: { model: 'chainmail' } });
    store.set({
        link: { client: 3 },
        shared: { tissue: { model: 'chainmail', has_vessel: true } } as never,
    });
    assert.ok(offersVessel(store.state.shared));
    show({ tissue: { model: 'vessel', has_vessel: true }, vessel: {} });
    assert.deepEqual(sent, []);
});

test('a surface is sent once, then displacements of its nodes', () => {
    const rest = Array.from({ length: 15 }, (_, i) => i + 0.25);
    const surface = decodeFrame(surfaceFrame(rest, [0, 1, 2, 2, 3, 4]));
    assert.ok(surface.kind === 'surface' && surface.volume === 3);
    const vessel = new Vessel(surface.rest, surface.corners);
    assert.deepEqual([...vessel.corners], [0, 1, 2, 2, 3, 4]);
    assert.deepEqual([...vessel.places], rest);
    const frame = decodeFrame(
        vesselFrame(
            [1, 2, 3, 4, 5, 6],
            [
                { first: 1, by: [0.5, 0, 0, 0, 3, 4] },
                { first: 4, by: [0, 0, -1] },
            ],
        ),
    );
    assert.ok(frame.kind === 'vessel');
    vessel.take(frame);
    assert.deepEqual([...vessel.moved], [0, 0.5, 5, 0, 1]);
    assert.equal(vessel.places[3], rest[3]! + 0.5);
    assert.equal(vessel.places[8], rest[8]! + 4);
    assert.equal(vessel.places[9], rest[9]);
    assert.deepEqual(vessel.catheter, [
        [1, 2, 3],
        [4, 5, 6],
    ]);
    assert.equal(vessel.radius, 0.75);
    const beyond = decodeFrame(vesselFrame([], [{ first: 4, by: [0, 0, 0, 0, 0, 0] }]));
    assert.ok(beyond.kind === 'vessel');
    assert.throws(() => vessel.take(beyond), /^Error: vessel: a run beyond its 5 nodes$/);
    assert.throws(() => decodeFrame(surfaceFrame(rest, [0, 1, 5])), /a corner beyond its 5 nodes/);
});

test('damaged frames of vessels are refused with a line', () => {
    let refused = 0;
    for (let i = 0; i < 3000; ++i) {
        const surface = i % 2 === 1;
        const frame = surface
            ? surfaceFrame([0, 0, 0, 1, 1, 1], [0, 1, 1])
            : vesselFrame([1, 2, 3], []);
        const bytes = new Uint8Array(frame);
        for (let n = whole(1, 4); n > 0; --n) bytes[whole(0, bytes.length - 1)] = whole(0, 255);
        try {
            decodeFrame(random() < 0.2 ? frame.slice(0, whole(0, bytes.length - 1)) : frame);
        } catch (error) {
            assert.match((error as Error).message, /^(frame|box|tools|surface|vessel): [^\n]+$/);
            ++refused;
        }
    }
    assert.ok(refused > 500);
});

test('arrows insert and rotate, with Shift they bend, and sticks do both', () => {
    const keys = (...held: string[]): unknown => wishOfKeys(new Set(held));
    assert.deepEqual(keys('ArrowUp'), { insert: 1, rotate: 0, bend: [0, 0] });
    assert.deepEqual(keys('ArrowDown', 'ArrowLeft'), { insert: -1, rotate: -1, bend: [0, 0] });
    assert.deepEqual(keys('ArrowUp', 'ArrowDown'), { insert: 0, rotate: 0, bend: [0, 0] });
    assert.deepEqual(keys('ShiftLeft', 'ArrowUp', 'ArrowRight'), {
        insert: 0,
        rotate: 0,
        bend: [1, 1],
    });
    const still = wishOfPad({ axes: [0.1, -0.14, 0.05, 0], buttons: [] });
    assert.deepEqual(still, { insert: 0, rotate: 0, bend: [0, 0] });
    const full = wishOfPad({ axes: [1, -1, -1, 1], buttons: [] });
    assert.deepEqual(full, { insert: 1, rotate: 1, bend: [-1, -1] });
    assert.deepEqual(sumOf(full, full), full);
    assert.deepEqual(wishOfPad({ axes: [], buttons: [] }).insert, 0);
    const cap = { id: '3Dconnexion SpaceMouse Compact', axes: [0, -1, 0, 1, 0, -1], buttons: [] };
    assert.deepEqual(wishOfPad(cap), { insert: 1, rotate: -1, bend: [-1, 0] });
});

test('a catheter of any length is a chain of points in bounding spheres', () => {
    for (const count of [2, 3, 12, 300, 700, 3000]) {
        const points: Vec3[] = Array.from({ length: count }, (_, i) => [
            10 * Math.cos(i / 4),
            10 * Math.sin(i / 4),
            0.3 * i,
        ]);
        const curve = drawnCurve(points);
        assert.ok(curve.length <= kMaxPoints && curve.length >= Math.min(count, kMaxPoints));
        assert.deepEqual(curve.at(-1), points.at(-1));
        if (count < 300)
            for (const p of points) assert.ok(curve.some((q) => norm(sub(p, q)) < 1e-9));
        const rows = catheterRows(curve, 0.8);
        assert.equal(rows[4 * (curve.length - 1) + 3], 0); // arc lengths begin at the tip
        for (let i = 1; i < curve.length; ++i) assert.ok(rows[4 * i + 3]! < rows[4 * i - 1]!);
        for (let i = 0; i + 1 < curve.length; ++i)
            for (const [row, each] of [
                [1, kGroup],
                [2, kGroup ** 2],
            ] as const) {
                const at = 4 * (row * kMaxPoints + Math.floor(i / each));
                const centre: Vec3 = [rows[at]!, rows[at + 1]!, rows[at + 2]!];
                for (const p of [curve[i]!, curve[i + 1]!])
                    assert.ok(norm(sub(p, centre)) + 0.8 <= rows[at + 3]!);
            }
    }
    assert.deepEqual(smoothed([]), []);
});

test('only segments around an eye in the catheter are left out', () => {
    const curve: Vec3[] = Array.from({ length: 41 }, (_, i) => [0, 0, i]);
    assert.deepEqual(gapAround([1.1, 0, 20], curve, 1), [0, 0]);
    assert.deepEqual(gapAround([0.9, 0, 20.5], curve, 1), [17, 24]);
    assert.deepEqual(gapAround([0, 0, 40.5], curve, 1), [37, 40]);
    assert.deepEqual(gapAround([0, 0, 0], [], 1), [0, 0]);
});

test('a section marks the catheter where it cuts it', () => {
    const plane = {
        centre: [0, 0, 5] as Vec3,
        axes: { right: [1, 0, 0], up: [0, 1, 0], normal: [0, 0, 1] },
        mmPerPixel: 1,
        width: 100,
        height: 100,
    } as unknown as Parameters<typeof chainParts>[1];
    const straight: Vec3[] = [
        [0, 0, 0],
        [0, 0, 4],
        [0, 4, 8],
    ];
    const marks = chainParts(straight, plane, 1);
    assert.equal(marks.filter((m) => !m.near).length, 1);
    const near = marks.filter((m) => m.near);
    assert.equal(near.length, 1); // the first segment only touches the range
    // From z = 4 to z = 6: y = 0 to y = 2.
    const heights = near[0]!.points.map(([, y]) => y);
    assert.ok(Math.abs(Math.abs(heights[0]! - heights[1]!) - 2) < 1e-9);
    assert.deepEqual(chainParts([[0, 0, 0]], plane, 1), []);
    // z = 5 is a quarter of the second segment: y = 1, at a millimetre per pixel.
    assert.deepEqual(crossings(straight, plane), [[50, 49]]);
    assert.deepEqual(crossings(straight.slice(0, 2), plane), []);
});

test('X-rays are attenuated by the tissue along them', () => {
    const grid = {
        size: [21, 21, 21] as Vec3,
        spacing: [2, 1, 1] as Vec3,
        origin: [-20, -10, -10] as Vec3,
        direction: [
            [1, 0, 0],
            [0, 1, 0],
            [0, 0, 1],
        ] as const,
    };
    const halves = new Uint16Array(21 ** 3).fill(halfOfFloat(500));
    const volume = new VolumeData(grid as never, halves);
    const along = (eye: Vec3, ray: Vec3): number =>
        waterAlong(volume, eye, ray, projectionOf(volume.grid, { eye, look: ray, up: [0, 0, 1] }));
    assert.ok(Math.abs(along([0, -500, 0], [0, 1, 0]) - 1.5 * 20) < 1e-6);
    assert.ok(Math.abs(along([-500, 0, 0], [1, 0, 0]) - 1.5 * 40) < 1e-6);
    // Beyond the scan the values fade out towards the end of the border.
    const border = Math.cbrt(40 * 20 * 20) / 3;
    for (const e of [0.1, 3, 0.9 * border]) {
        const left = (1 - (e / border) ** 2) ** 2;
        assert.ok(Math.abs(along([20 + e, -500, 0], [0, 1, 0]) - 30 * left) < 1e-3);
    }
    assert.equal(along([0, -500, 10.1 + border], [0, 1, 0]), 0);
    const camera = { eye: [0, -500, 0] as Vec3, look: [0, 1, 0] as Vec3, up: [0, 0, 1] as Vec3 };
    assert.ok(Math.abs(usualWater(volume, camera, 2, 1) - 30) < 0.1);
    assert.equal(usualWater(volume, { ...camera, look: [0, -1, 0] }, 2, 1), 0);
});

/// Inner surface of a vessel: a tube about a bent line in any direction.
function bentVessel(): { vessel: Vessel; line: Vec3[] } {
    const [u, v, w] = frame();
    const bend = between(-0.6, 0.6);
    const line = Array.from({ length: 40 }, (_, i): Vec3 => {
        const [x, y] = [3 * i, bend * 0.02 * (3 * i) ** 2];
        return add([between(-1, 1), 200, -300], add(mul(x, u), mul(y, v)));
    });
    const rest = new Float32Array(
        line.flatMap((p) =>
            Array.from({ length: 12 }, (_, k) => {
                const angle = (k * Math.PI) / 6;
                return add(p, add(mul(6 * Math.cos(angle), v), mul(6 * Math.sin(angle), w)));
            }).flat(),
        ),
    );
    const vessel = new Vessel(rest, new Uint32Array([0, 1, 2]));
    vessel.catheter = line.slice(0, whole(2, 20));
    return { vessel, line };
}

function frame(): [Vec3, Vec3, Vec3] {
    const u = normalized([between(-1, 1), between(-1, 1), between(-1, 1)]);
    const v = normalized(cross(u, [0.3, 0.5, 0.8]));
    return [u, v, cross(u, v)];
}

test('principal axes are perpendicular and sorted by variance', () => {
    for (let round = 0; round < 30; ++round) {
        const axes = frame();
        const places = Array.from({ length: 200 }, () =>
            [1, 3, 9].reduce(
                (p: Vec3, width, a) => along(p, between(-width, width), axes[a]!),
                [5, 6, 7],
            ),
        );
        principalAxes(places).forEach((axis, a) => {
            assert.ok(Math.abs(norm(axis) - 1) < 1e-9);
            assert.ok(Math.abs(dot(axis, axes[a]!)) > 0.97, `${axis} for ${axes[a]}`);
        });
    }
});

test('the first outside view shows a whole vessel with its catheter', () => {
    const slope = Math.tan((15 * Math.PI) / 180);
    for (let round = 0; round < 30; ++round) {
        const { vessel } = bentVessel();
        const { centre, direction, up, distance } = outsideOf(vessel, slope);
        assert.ok(Math.abs(dot(direction, up)) < 1e-9 && direction[1] >= 0);
        const eye = along(centre, -distance, direction);
        const right = cross(direction, up);
        let widest = 0;
        const nodes: Vec3[] = [...vessel.catheter];
        for (let n = 0; n < vessel.rest.length; n += 3)
            nodes.push([vessel.rest[n]!, vessel.rest[n + 1]!, vessel.rest[n + 2]!]);
        for (const p of nodes) {
            const off = sub(p, eye);
            const depth = dot(off, direction) * slope;
            assert.ok(depth > 0);
            for (const axis of [right, up])
                widest = Math.max(widest, Math.abs(dot(off, axis)) / depth);
        }
        assert.ok(widest < 1 && widest > 0.6, `${widest} of the picture`);
    }
});

test('the first view in a vessel is of the catheter’s tip, from the lumen beside it', () => {
    const scene = new MockScene();
    const volume = new VolumeData(kGrid, scene.halves);
    const surface = { iso: -500, rising: true };
    const vessel = new Vessel(new Float32Array(9), new Uint32Array([0, 1, 2]));
    vessel.radius = 0.8;
    for (let round = 0; round < 20; ++round) {
        const from = between(-30, 20);
        const count = whole(2, 8);
        const off = mul(between(0, 7), normalized([between(-1, 1), between(-1, 1), 0]));
        vessel.catheter = Array.from({ length: count }, (_, i) =>
            add(tubeCentre(from + 3 * i), off),
        );
        const camera = behindTip(vessel, volume, surface)!;
        const tip = vessel.catheter.at(-1)!;
        const value = volume.sample(voxelFromWorld(kGrid, camera.eye));
        assert.ok(value < -500, `${value} HU at the eye`);
        for (let i = 0; i + 1 < count; ++i) {
            const [a, b] = [vessel.catheter[i]!, vessel.catheter[i + 1]!];
            assert.ok(distanceToSegment(camera.eye, a, b) > vessel.radius + 0.2);
        }
        const way = sub(tip, camera.eye);
        assert.ok(dot(normalized(way), camera.look) > Math.cos(0.7), 'the tip is in the picture');
        assert.equal(firstHit(volume, camera.eye, way, surface, norm(way)), undefined);
    }
    // A catheter that fills its vessel leaves no room for the camera.
    vessel.radius = 9.5;
    vessel.catheter = [tubeCentre(0), tubeCentre(3)];
    assert.equal(behindTip(vessel, volume, surface), undefined);
});

test('an endoscope rides behind the tip in the lumen, without sudden turns', () => {
    const scene = new MockScene();
    const volume = new VolumeData(kGrid, scene.halves);
    const surface = { iso: -500, rising: true };
    const vessel = new Vessel(new Float32Array(9), new Uint32Array([0, 1, 2]));
    vessel.radius = 0.8;
    const aside: Vec3 = [3, 2, 0];
    const points = Array.from({ length: 80 }, (_, i) => add(tubeCentre(-38 + i), aside));
    vessel.catheter = points.slice(0, 15);
    let camera = onTip(vessel, volume, surface, behindTip(vessel, volume, surface)!)!;
    for (let count = 16; count <= points.length; ++count) {
        vessel.catheter = points.slice(0, count);
        const next = onTip(vessel, volume, surface, camera)!;
        const tip = points[count - 1]!;
        const tangent = normalized(sub(tip, points[count - 2]!));
        assert.ok(volume.sample(voxelFromWorld(kGrid, next.eye)) < -500);
        const away = norm(sub(tip, next.eye));
        assert.ok(away > 8 && away < 13, `${away} mm from the tip`);
        assert.ok(dot(next.look, tangent) > Math.cos(0.35), `${next.look} along ${tangent}`);
        assert.ok(Math.abs(dot(next.up, next.look)) < 1e-9);
        // A millimetre ahead, the eye stays on its side and the picture keeps its roll.
        assert.ok(norm(sub(next.eye, camera.eye)) < 2, `${norm(sub(next.eye, camera.eye))} mm`);
        assert.ok(dot(next.look, camera.look) > Math.cos(0.15));
        assert.ok(dot(next.up, camera.up) > Math.cos(0.15));
        camera = next;
    }
    vessel.catheter = points.slice(0, 1);
    assert.equal(onTip(vessel, volume, surface, camera), undefined);
});

test('two planes of fluoroscopy are at a right angle, and positions fall into one of them', () => {
    const state = initialState();
    const { orbit } = state.view;
    const one = { ...state, view: { ...state.view, outside: true, fluoroscopy: true } };
    const two = { ...one, fluoro: { ...state.fluoro, biplane: true } };
    assert.equal(planesOf(one, { width: 301, height: 200 }).length, 1);
    for (const [width, height] of [
        [301, 200],
        [200, 301],
    ] as const) {
        const [first, second] = planesOf(two, { width, height });
        assert.deepEqual(first!.view, two.view);
        const turned = second!.view.orbit;
        assert.ok(Math.abs(dot(turned.direction, orbit.direction)) < 1e-9);
        assert.ok(norm(sub(turned.up, orbit.up)) < 1e-9, 'the vertical axis stays');
        assert.deepEqual(turned.centre, orbit.centre);
        assert.equal(second!.x + second!.width, width);
        assert.equal(second!.y + second!.height, height);
        const under = planeUnder(two, { x: width - 10, y: height - 20, width, height });
        assert.deepEqual(under.view, second!.view);
        assert.equal(under.spot.x, second!.width - 10);
        assert.equal(under.spot.y, second!.height - 20);
        assert.deepEqual(planeUnder(two, { x: 5, y: 6, width, height }).view, two.view);
    }
});
