// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Silhouettes of instruments and catheters, pixel by pixel, against projections computed here:
// points of each solid, from its description, through a pinhole. The picture has no wall and the
// lens no distortion, so that each pixel is either of an instrument or of the fog.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Camera } from '../src/maths/rays.ts';
import { add, along, cross, dot, mul, norm, normalized, sub, type Vec3 } from '../src/maths/vec.ts';
import type { Look } from '../src/state/state.ts';
import type { Patch } from '../src/state/store.ts';
import type { Session } from '../src/tools/session.ts';
import { headOpacity, type ToolBall, type ToolKind } from '../src/views/instruments.ts';
import { different, drawn, misses } from './drawn.ts';
import { tubeCentre } from './mock_scene.ts';
import { page, useOnePage } from './one_page.ts';
import { between, random } from './random.ts';

// The mock's scan is a bent tube, the program's an airway.
const kServer = process.env.PLIANT_SERVER !== undefined;

useOnePage();

const kSize = 161; // pixels of the picture, both ways
const kNothing = 30000; // threshold beyond all voxels [HU]
const kCamera: Camera = { eye: [1, -2, 3], look: [0, 1, 0], up: [0, 0, 1] };
const kField = 80;
const kSlope = Math.tan((kField * Math.PI) / 360);
const stateAt = (camera: Camera, look: Partial<Look> = { style: 'plain' }): Patch => ({
    view: { camera, fieldOfView: kField, barrel: 0, fog: 0, outside: false },
    look,
});
const empty = { width: kSize, height: kSize, state: stateAt(kCamera), iso: kNothing };

/// Camera's axes of kCamera, by hand: x to the right, y ahead, z up.
const pixelOf = (p: Vec3): [number, number] | undefined => {
    const [x, y, z] = sub(p, kCamera.eye);
    if (y < 1e-3) return undefined;
    const half = kSize / 2;
    return [half + (half * x) / (y * kSlope), half - (half * z) / (y * kSlope)];
};

/// Mask of a picture from points of solids.
class Mask {
    readonly pixels: boolean[] = new Array<boolean>(kSize * kSize).fill(false);

    point(p: Vec3): void {
        const spot = pixelOf(p);
        if (!spot) return;
        const [x, y] = [Math.floor(spot[0]), Math.floor(spot[1])];
        // Only points near a pixel's centre, so that narrow gaps stay open.
        if (Math.abs(spot[0] - x - 0.5) > 0.25 || Math.abs(spot[1] - y - 0.5) > 0.25) return;
        if (x >= 0 && y >= 0 && x < kSize && y < kSize) this.pixels[y * kSize + x] = true;
    }

    /// Points of a solid in the box c ± half along axes.
    solid(c: Vec3, axes: [Vec3, Vec3, Vec3], half: Vec3, holds: (q: Vec3) => boolean): void {
        const count = half.map((h) => Math.ceil(h / 0.045));
        for (let i = -count[0]!; i <= count[0]!; ++i)
            for (let j = -count[1]!; j <= count[1]!; ++j)
                for (let k = -count[2]!; k <= count[2]!; ++k) {
                    const q: Vec3 = [
                        (i / count[0]!) * half[0],
                        (j / count[1]!) * half[1],
                        (k / count[2]!) * half[2],
                    ];
                    if (!holds(q)) continue;
                    const [a, b, e] = axes;
                    this.point(add(c, add(add(mul(q[0], a), mul(q[1], b)), mul(q[2], e))));
                }
    }

    sphere(c: Vec3, r: number): void {
        const axes: [Vec3, Vec3, Vec3] = [
            [1, 0, 0],
            [0, 1, 0],
            [0, 0, 1],
        ];
        this.solid(c, axes, [r, r, r], (q) => norm(q) <= r);
    }

    /// Points of discs across the segment from a to b, denser near the lens.
    capsule(a: Vec3, b: Vec3, r: number): void {
        this.sphere(b, r);
        const way = sub(b, a);
        const unit = normalized(way);
        const u = normalized(cross(unit, [0.3, 0.5, 0.8]));
        const v = cross(unit, u);
        for (let s = 0; s < norm(way); s += 0.025) {
            const c = along(a, s, unit);
            for (let n = 0; n < 480; ++n) {
                const angle = (n * Math.PI) / 240;
                for (const part of [1, 0.7, 0.4, 0.1])
                    this.point(
                        along(
                            along(c, part * r * Math.cos(angle), u),
                            part * r * Math.sin(angle),
                            v,
                        ),
                    );
            }
        }
    }
}

const kShaft: Record<'ball' | 'grasper' | 'blade' | 'scoop', number> = {
    ball: 0,
    grasper: 1.55,
    blade: 2,
    scoop: 0.8,
};

/// Pose of an own tool in free space, as described in instruments.ts.
function poseOf(kind: keyof typeof kShaft, centre: Vec3, radius: number) {
    const offset: Vec3 = [3.2, -1, -3]; // right, ahead, up
    const base = along(kCamera.eye, Math.min(1, radius / 2), offset);
    const ray = normalized(sub(centre, kCamera.eye));
    const shaft = normalized(sub(centre, base));
    const aside = normalized(along(shaft, -dot(shaft, ray), ray));
    const lean = Math.max(Math.acos(dot(shaft, ray)), (58 * Math.PI) / 180);
    const h = kind === 'ball' ? shaft : add(mul(Math.cos(lean), ray), mul(Math.sin(lean), aside));
    const wrist = along(centre, -kShaft[kind] * radius, h);
    const off = sub(kCamera.eye, wrist);
    const e = normalized(along(off, -dot(off, h), h));
    const thickness = Math.max(Math.min(0.26 * radius, 0.6), 0.2);
    return { base, wrist, h, e, v: cross(h, e), thickness };
}

function expected(kind: keyof typeof kShaft, centre: Vec3, r: number, closed: boolean): boolean[] {
    const { base, wrist, h, e, v, thickness } = poseOf(kind, centre, r);
    const mask = new Mask();
    mask.capsule(base, wrist, thickness);
    if (kind === 'ball') mask.sphere(centre, r);
    if (kind === 'grasper') {
        mask.sphere(wrist, 0.28 * r);
        const angle = closed ? -0.03 : 0.5;
        for (const sign of [-1, 1]) {
            const out = mul(sign, v);
            const a = add(mul(Math.cos(angle), h), mul(Math.sin(angle), out));
            const b = sub(mul(Math.cos(angle), out), mul(Math.sin(angle), h));
            const half: Vec3 = [0.88 * r, 0.16 * r, 0.28 * r];
            const c = add(wrist, add(mul(0.85 * r, a), mul(0.14 * r, b)));
            mask.solid(
                c,
                [a, b, e],
                half,
                (q) => norm([q[0] / half[0], q[1] / half[1], q[2] / half[2]]) <= 1,
            );
        }
    }
    if (kind === 'blade') {
        // Back, point and edge: a rectangle 0.8 r wide, cut by a slanting line.
        const [x0, y0] = [0.15 * r, 0.3 * r];
        const half: Vec3 = [2.2 * r, 0.5 * r, 0.07 * r];
        mask.solid(
            centre,
            [h, v, e],
            half,
            ([x, y]) => y <= 0.3 * r && 0.5 * (x - x0) - (y - y0) <= 0,
        );
    }
    if (kind === 'scoop') {
        const s = 0.85 * r;
        const mouth = normalized(add(mul(0.3, h), e));
        for (let n = 0; n < 600_000; ++n) {
            const z = between(-1, 0.1);
            const angle = between(0, 2 * Math.PI);
            const flat = Math.sqrt(1 - z * z);
            const u = normalized(cross(mouth, [0.3, 0.5, 0.8]));
            const w = cross(mouth, u);
            const place = add(
                mul(z, mouth),
                add(mul(flat * Math.cos(angle), u), mul(flat * Math.sin(angle), w)),
            );
            mask.point(along(centre, s, place));
        }
    }
    return mask.pixels;
}

async function silhouette(balls: ToolBall[]): Promise<boolean[]> {
    const [without, withTool] = [await drawn(page, empty), await drawn(page, { ...empty, balls })];
    return different(without, withTool);
}

for (const [kind, radius, closed] of [
    ['ball', 3, false],
    ['grasper', 4, false],
    ['grasper', 4, true],
    ['blade', 2.5, false],
    ['scoop', 4, false],
] as const)
    test(`pixels of the ${kind}${closed ? ', closed' : ''}`, async () => {
        for (let round = 0; round < 3; ++round) {
            const centre: Vec3 = [between(-3, 4), between(14, 20), between(-1, 6)];
            const found = await silhouette([{ centre, radius, kind, closed, own: true }]);
            const solid = expected(kind, centre, radius, closed);
            const missed = misses(found, solid, kSize);
            assert.deepEqual(missed, [], `${kind} at ${centre.join(' ')}`);
            const steel = solid.filter(Boolean).length;
            assert.ok(steel > 150 && steel < 6000, `${steel} pixels`);
        }
    });

test('jaws meet in the tissue that they hold, and leave most of it visible', async () => {
    const centre: Vec3 = [1, 16, 3];
    const tool = { centre, radius: 4, own: true, kind: 'grasper' as const };
    const open = await silhouette([{ ...tool, closed: false }]);
    const shut = await silhouette([{ ...tool, closed: true }]);
    const [x, y] = pixelOf(centre)!;
    const middle = Math.floor(y) * kSize + Math.floor(x);
    assert.ok(
        !open[middle] && shut[middle],
        'the jaws meet in the middle of the tissue that they hold',
    );
    // At least three quarters of the visible part of the held disc are free.
    const held = new Mask();
    held.sphere(centre, 4);
    const disc = held.pixels.filter(Boolean).length;
    const hidden = held.pixels.filter((on, i) => on && shut[i]).length;
    assert.ok(hidden < 0.25 * disc, `${hidden} of ${disc} pixels are hidden`);
});

test('pixels of another client’s scope', async () => {
    const centre: Vec3 = [-2, 18, 5];
    const direction = normalized([0.8, 0.1, 0.4]);
    const kind: ToolKind = 'scope';
    const found = await silhouette([{ centre, radius: 2, kind, direction, own: false }]);
    const mask = new Mask();
    mask.capsule(along(centre, -60, direction), centre, 0.85 * 2);
    assert.deepEqual(misses(found, mask.pixels, kSize), []);
    assert.ok(mask.pixels.filter(Boolean).length > 400);
});

test('a catheter 0.3 mm beside the eye is drawn whole', async () => {
    const radius = 0.8;
    const off = radius + 0.3;
    const without = await drawn(page, empty);
    // One and a half pictures in total: some catheters are mostly behind the eye.
    let covered = 0;
    for (let round = 0; round < 12 || covered < 1.5; ++round) {
        assert.ok(round < 100, `${covered} pictures in all`);
        // A straight catheter whose nearest point is beside or right in front of the eye.
        const unit = normalized([between(-1, 1), between(-1, 1), between(-1, 1)]);
        const aside = normalized(cross(unit, [random() - 0.5, random() - 0.5, random() - 0.5]));
        const nearest = along(kCamera.eye, off, aside);
        const catheter = Array.from({ length: 61 }, (_, i) => along(nearest, 3 * (i - 30), unit));
        const found = different(without, await drawn(page, { ...empty, catheter, radius }));
        // Across the axis it is a disc: a ray hits it within an angle about the direction to its
        // centre. Along the axis it ends 90 mm away.
        const u = aside;
        const v = cross(unit, u);
        const solid = found.map((_, i) => {
            const x = ((i % kSize) + 0.5) / (kSize / 2) - 1;
            const y = 1 - (Math.floor(i / kSize) + 0.5) / (kSize / 2);
            const ray = normalized([kSlope * x, 1, kSlope * y]);
            const [a, b] = [dot(ray, u), dot(ray, v)];
            const across = Math.hypot(a, b);
            if (across < 1e-9 || a / across < Math.sqrt(1 - (radius / off) ** 2)) return false;
            const way = (off * a - Math.sqrt(radius ** 2 * across ** 2 - (off * b) ** 2)) / across;
            return (way * Math.abs(dot(ray, unit))) / across < 90;
        });
        assert.deepEqual(misses(found, solid, kSize).slice(0, 5), [], `along ${unit.join(' ')}`);
        covered += solid.filter(Boolean).length / solid.length;
    }
});

test('a probe that covers much of the field shows the wall behind it', async () => {
    const eye: Vec3 = kServer ? [0.3, -2.2, 40] : tubeCentre(20);
    const camera: Camera = { eye, look: [0, 0, -1], up: [0, 1, 0] };
    const ballOf = (radius: number, kind: ToolKind = 'ball'): ToolBall => {
        return { centre: along(eye, 9, camera.look), radius, own: true, kind };
    };
    const opacityOf = (ball: ToolBall): number => headOpacity(ball, eye, kField);
    assert.equal(opacityOf(ballOf(1.5)), 1);
    assert.equal(opacityOf(ballOf(4, 'grasper')), 1);
    for (const radius of [4, 8.9, 9, 12]) {
        const opacity = opacityOf(ballOf(radius));
        assert.ok(opacity > 0.2 && opacity < 0.3, `${radius} mm: ${opacity}`);
    }
    // Pixels at 0.7 radii from the middle, with a wall and without.
    for (const [radius, seen] of [
        [1.5, false],
        [4, true],
    ] as const) {
        const scene = { ...empty, state: stateAt(camera), balls: [ballOf(radius)] };
        const at = Math.floor(kSize / 2 + (0.7 * radius * kSize) / (2 * 9 * kSlope));
        const pixel = 3 * (Math.floor(kSize / 2) * kSize + at);
        const [wall, none] = [await drawn(page, { ...scene, iso: -500 }), await drawn(page, scene)];
        const off = Math.abs(wall[pixel]! - none[pixel]!);
        assert.ok(seen ? off > 10 : off === 0, `${radius} mm: ${off}`);
    }
});

test('a band every centimetre, and a pale tip', async () => {
    const catheter: Vec3[] = Array.from({ length: 15 }, (_, i) => [4 * i - 28, 14, 3]);
    const rows = await drawn(page, { ...empty, catheter, radius: 0.8 });
    const at = (way: number): number => {
        const [x, y] = pixelOf([28 - way, 14 - 0.8, 3])!;
        const i = 3 * (Math.floor(y) * kSize + Math.floor(x));
        return rows[i]! + rows[i + 1]! + rows[i + 2]!;
    };
    // The eye is at x = 1: points 18 to 40 mm from the tip are visible.
    for (const centimetre of [20, 30]) {
        const [before, band, after] = [-1.5, 0.6, 2.6].map((way) => at(centimetre + way));
        assert.ok(band! < 0.75 * before! && band! < 0.75 * after!, `${before} ${band} ${after}`);
    }
    const turned = catheter.map(([x, y, z]): Vec3 => [x - 20, y, z]);
    const pale = await drawn(page, { ...empty, catheter: turned, radius: 0.8 });
    const tip = (x: number): number[] => {
        const [px, py] = pixelOf([x, 14 - 0.8, 3])!;
        const i = 3 * (Math.floor(py) * kSize + Math.floor(px));
        return [...pale.subarray(i, i + 3)];
    };
    const [red, , blue] = tip(7);
    assert.ok(red! > blue! + 20, `${tip(7)}`);
    assert.ok(tip(3)[2]! > tip(3)[0]! + 20, `${tip(3)}`);
});

/// Distances to the wall [mm], by sampling the page's scan.
const wallFrom = (rays: readonly { from: Vec3; way: Vec3 }[]): Promise<number[]> =>
    page.evaluate((all) => {
        const { volume, store } = (window as never as { pliant: Session }).pliant;
        const { grid } = volume!;
        return all.map(({ from, way }) => {
            for (let t = 0.5; t < 100; t += 0.02) {
                const v = from.map((x, a) => x + t * way[a]! - grid.origin[a]!);
                const ijk = grid.direction.map(
                    (axis, a) => axis.reduce((sum, x, b) => sum + x * v[b]!, 0) / grid.spacing[a]!,
                );
                if (volume!.sample(ijk as never) > store.state.shared!.iso_hu) return t;
            }
            throw new Error('no wall');
        });
    }, rays);

test('instruments darken the wall that they touch alone', async () => {
    // View along a tube, with instruments at its wall, to the right of the eye.
    const eye: Vec3 = kServer ? [0.3, -2.2, 40] : tubeCentre(20);
    const camera: Camera = { eye, look: [0, 0, -1], up: [0, 1, 0] };
    const kBall = 18; // distance ahead of the eye [mm]
    const ahead = Array.from({ length: 20 }, (_, i) => 2 + (kServer ? 1 : 2) * i);
    const at = (far: number): Vec3 => along(eye, far, camera.look);
    const way = (degrees: number): Vec3 => {
        const angle = (degrees * Math.PI) / 180;
        return [Math.cos(angle), Math.sin(angle), 0];
    };
    const right = await wallFrom([...ahead, kBall].map((far) => ({ from: at(far), way: way(0) })));
    const inside = (far: number, room: number, depth: number): Vec3 =>
        along(at(far), room - depth, way(0));
    const catheter = ahead.map((far, i) => inside(far, right[i]!, 0.8)).reverse();
    const ball: ToolBall = {
        centre: inside(kBall, right.at(-1)!, 1),
        radius: 2,
        own: true,
        kind: 'ball',
    };
    // Beside the ball and the catheter, and far away.
    const beside = { ball: 2.55, catheter: 1.1 }; // [mm]
    const degreesOf = (mm: number): number => (mm / right.at(-1)!) * (180 / Math.PI);
    const angles = [
        ...[beside.ball, -beside.ball, beside.catheter, -beside.catheter].map(degreesOf),
        ...[120, 180, -120],
    ];
    const rooms = await wallFrom(angles.map((angle) => ({ from: at(kBall), way: way(angle) })));
    for (const style of ['plain', 'real'] as const) {
        const scene = {
            width: kSize,
            height: kSize,
            state: stateAt(camera, { style, fieldStop: 'full' }),
        };
        const bare = await drawn(page, scene);
        for (const [name, more] of [
            ['catheter', { catheter, radius: 0.8 }],
            ['ball', { balls: [ball] }],
        ] as const) {
            const rows = await drawn(page, { ...scene, ...more });
            const share = (degrees: number): number => {
                const p = along(at(kBall), rooms[angles.indexOf(degrees)]!, way(degrees));
                const [dx, dy, dz] = sub(p, camera.eye);
                const x = Math.floor(kSize / 2 + (kSize * dx) / (2 * -dz * kSlope));
                const y = Math.floor(kSize / 2 - (kSize * dy) / (2 * -dz * kSlope));
                const i = 3 * (y * kSize + x);
                const sum = (a: Uint8Array): number => a[i]! + a[i + 1]! + a[i + 2]!;
                return sum(rows) / sum(bare);
            };
            for (const side of [-1, 1]) {
                const near = share(degreesOf(side * beside[name]));
                assert.ok(near < 0.85, `${style} ${name}: ${near} beside it`);
            }
            for (const degrees of [120, 180, -120]) {
                const far = share(degrees);
                assert.ok(Math.abs(far - 1) < 0.02, `${style} ${name}: ${far} at ${degrees}`);
            }
        }
    }
});

test('a ray in a plane between bricks finds its wall', async () => {
    // Bricks of 4 voxels meet at z = 0 and 45; the middle row is hardly tilted.
    const middle = (kSize - 1) / 2;
    for (const z of [0, 45])
        for (const tilt of [0, -1e-10, -3e-8, -1e-7, -3e-7, 1e-7]) {
            const [x0, y0] = tubeCentre(z);
            const camera: Camera = { eye: [x0, y0, z], look: [0, 1, tilt], up: [0, 0, 1] };
            const wanted = { ...empty, state: stateAt(camera), iso: -500 };
            const rows = await drawn(page, wanted);
            for (let x = 10; x + 10 < kSize; ++x) {
                const at = (y: number): number => rows[3 * (y * kSize + x)]!;
                const around = 0.5 * (at(middle - 1) + at(middle + 1));
                assert.ok(Math.abs(at(middle) - around) < 12, `${z}, ${tilt}: ${x}`);
            }
        }
});
