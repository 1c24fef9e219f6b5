// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Volume rendering in the page. Ramps are compared with `pliant render --view blended`, of the same
// camera, in all pixels: they share definitions, but no code. C++ samples the middles of its steps,
// the page positions that differ from pixel to pixel. Bounds, in 0…255: 1.0 on average over all
// pixels and channels, and at most 1 % of the pixels off by more than 16; four times as much for
// bones. All other transfer functions are compared with the same equations in JavaScript, at the
// same positions.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import type { Page } from 'playwright-core';
import { blendAlong } from '../src/maths/blend.ts';
import { type Camera, rayThrough } from '../src/maths/rays.ts';
import { adjusted, linearOf, rampOf, type Transfer } from '../src/maths/transfer.ts';
import { along, cross, mul, type Vec3 } from '../src/maths/vec.ts';
import type { VolumeData } from '../src/maths/volume.ts';
import type { Orbit, Rendering } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import type { ToolBall } from '../src/views/instruments.ts';
import { kOutsideField, orbitCamera } from '../src/views/orbit.ts';
import {
    kPictures,
    launch,
    picture,
    pixels,
    rectOf,
    serve,
    stateOf,
    still,
    untilUndo,
    visit,
} from './browser.ts';
import { different, drawn } from './drawn.ts';
import { mirrorOf } from './mirror.ts';
import { page, useOnePage } from './one_page.ts';
import { type Difference, pixelDifference } from './picture_difference.ts';
import { kThorax } from './setups.ts';

const program = process.env.PLIANT_SERVER;
const folder = mkdtempSync(join(tmpdir(), 'pliant-volume-'));
after(() => rmSync(folder, { recursive: true }));

// --- the same picture as in C++

const kMean = 1.0;
const kMaxFar = 0.01;

interface Kind {
    readonly low?: number; ///< lower end of the window [HU]
    readonly high?: number;
    readonly opacity?: number; ///< [1/mm]
    readonly look?: Vec3;
    readonly near?: number; ///< factor of the distance
    readonly state?: string; ///< file of the tissue's state, for C++
    readonly offOpacity?: number; ///< factor of the opacity in C++
    readonly fine?: boolean; ///< the mean of several pictures, as on slow machines when still
}

type Found = Pick<Difference, 'mean' | 'far'>;

async function compare(shown: Page, scan: string, name: string, kind: Kind): Promise<Found> {
    const { low = -100, high = 400, opacity = 0.25, near = 0.6, look = [0, 1, 0] } = kind;
    const transfer = rampOf(low, high, opacity);
    await shown.evaluate(
        ([ramp, direction, distance, fine]) => {
            const { store } = (window as never as { pliant: Session }).pliant;
            const { orbit } = store.state.view;
            store.set({
                display: { fine },
                view: {
                    outside: true,
                    blended: true,
                    orbit: { ...orbit, direction, distance: distance * orbit.distance },
                },
                rendering: { preset: 'test', transfer: ramp, opacity: 1, shift: 0, cut: false },
            });
        },
        [transfer, look, near, kind.fine ?? false] as const,
    );
    await shown.waitForTimeout(300);
    await still(shown);
    const { view } = await stateOf(shown);
    const box = await rectOf(shown, 'endoscope');
    const file = join(kPictures, `${name}_cpp.png`);
    const { eye, look: ahead, up } = orbitCamera(view);
    execFileSync(program!, [
        'render',
        scan,
        `--out=${file}`,
        '--view=blended',
        `--eye=${eye.join(',')}`,
        `--look=${ahead.join(',')}`,
        `--up=${up.join(',')}`,
        `--fov=${kOutsideField}`,
        '--barrel=0',
        `--size=${Math.round(box.width)}x${Math.round(box.height)}`,
        `--window=${high - low}`,
        `--level=${0.5 * (low + high)}`,
        `--opacity=${opacity * (kind.offOpacity ?? 1)}`,
        ...(kind.state ? [`--load-state=${kind.state}`] : []),
    ]);
    await picture(shown, `${name}_browser`);
    const found = await pixelDifference(shown, file);
    console.log(`# ${name}: mean ${found.mean.toFixed(2)}, far ${(100 * found.far).toFixed(2)} %`);
    await shown.evaluate((distance) => {
        const { store } = (window as never as { pliant: Session }).pliant;
        const { orbit } = store.state.view;
        store.set({ view: { orbit: { ...orbit, distance: orbit.distance / distance } } });
    }, near);
    return found;
}

/// Compares pictures of one scan. @param commands  to the tissue, before the pictures
async function compareAll(
    scan: string,
    kinds: Record<string, Kind>,
    commands: readonly object[] = [],
): Promise<Found[]> {
    const browser = await launch();
    const served = await serve(scan);
    const { page: shown, errors } = await visit(browser, served.link);
    for (const command of commands)
        assert.ok(
            await shown.evaluate(
                (c) => (window as never as { pliant: Session }).pliant.ask(c as never),
                command,
            ),
        );
    const found: Found[] = [];
    for (const [name, kind] of Object.entries(kinds))
        found.push(await compare(shown, scan, `volume_${name}`, kind));
    await browser.close();
    await served.stop();
    assert.deepEqual(errors, []);
    return found;
}

const bound = ({ mean, far }: Found, factor = 1): void =>
    assert.ok(mean < factor * kMean && far < factor * kMaxFar, `mean ${mean}, far ${far}`);

function airway(): string {
    const scan = join(folder, 'airway.nrrd');
    if (!existsSync(scan))
        execFileSync(program!, ['phantom', 'airway', '--size', '96', '--out', scan]);
    return scan;
}

test(
    'the phantom as a volume looks the same as in C++, but not with a fifth more opacity',
    { skip: !program },
    async () => {
        const [usual, glass, steep, oblique, off] = await compareAll(airway(), {
            phantom: {},
            glass: { low: -900, high: 600, opacity: 0.01 },
            steep: { low: -300, high: 100, opacity: 0.4 },
            oblique: { look: [0.6, 0.64, -0.48] },
            off: { low: -900, high: 600, opacity: 0.01, offOpacity: 1.2 },
        });
        for (const found of [usual, glass, steep, oblique]) bound(found!);
        assert.ok(off!.mean > 2 * kMean, `mean ${off!.mean}`);
    },
);

test(
    'a CT as a volume looks the same as in C++',
    { skip: !program || !existsSync(kThorax) },
    async () => {
        const [ct, bones] = await compareAll(kThorax, {
            ct: {},
            ct_bones: { low: 180, high: 500, opacity: 0.5, fine: true },
        });
        bound(ct!);
        bound(bones!, 4); // thin and opaque: half a voxel is too coarse for both
    },
);

test(
    'a pushed and carved volume looks the same as in C++, and not as at rest',
    { skip: !program },
    async () => {
        const scan = airway();
        const [point, push]: Vec3[] = [
            [30, -46, -30],
            [0, 12, 0],
        ];
        const [from, to]: Vec3[] = [
            [-15, -60, 0],
            [-15, -30, 0],
        ];
        const state = join(folder, 'pushed.plst');
        execFileSync(program!, [
            'deform',
            scan,
            '--tool=sphere:8',
            '--solver=sweep', // limits of a box, as a server's tissue has them
            `--push=${point!.join(',')}:${push!.join(',')}`,
            `--carve=${from!.join(',')};${to!.join(',')}:10`,
            `--out=${join(folder, 'pushed.nrrd')}`,
            `--save-state=${state}`,
        ]);
        const [pushed, atRest] = await compareAll(
            scan,
            {
                pushed: { near: 0.3, state },
                pushed_at_rest: { near: 0.3 },
            },
            [
                { do: 'push', point, push, radius: 8 },
                { do: 'carve', from, to, radius: 10 },
            ],
        );
        bound(pushed!);
        assert.ok(atRest!.mean > 2 * kMean, `mean ${atRest!.mean}`);
    },
);

// --- other transfer functions, tools, and the page around them

const kBand: Transfer = [
    { value: -950, perMm: 0, colour: [120, 160, 200] },
    { value: -700, perMm: 0.05, colour: [40, 220, 60] },
    { value: -400, perMm: 0, colour: [235, 190, 170] },
    { value: 100, perMm: 0, colour: [255, 255, 255] },
    { value: 300, perMm: 0.8, colour: [255, 60, 20] },
];
const kThin = rampOf(-900, -100, 0.02);
const kOpaque = rampOf(-800, -700, 5);
const [kWidth, kHeight] = [96, 72];
const kFog = linearOf(8);

let volume: VolumeData;
let orbit: Orbit;
useOnePage({
    size: 64,
    ready: async () => {
        volume = await mirrorOf(page);
        ({ orbit } = (await stateOf(page)).view);
        orbit = { ...orbit, distance: 0.6 * orbit.distance, direction: [0.6, 0.64, -0.48] };
    },
});

interface Scene {
    readonly transfer: Transfer;
    readonly rendering?: Partial<Rendering>;
    readonly balls?: readonly ToolBall[];
    readonly catheter?: readonly Vec3[];
    readonly moving?: boolean;
    readonly eye?: Vec3; ///< of the endoscope
}

const draw = ({ transfer, rendering, eye, ...more }: Scene): Promise<Uint8Array> =>
    drawn(page, {
        width: kWidth,
        height: kHeight,
        state: {
            view: {
                outside: true,
                blended: true,
                orbit,
                // By default the endoscope is out of sight, behind the viewer.
                camera: { eye: eye ?? behindViewer(), look: [0, 0, -1], up: [0, 1, 0] },
            },
            rendering: { transfer, opacity: 1, shift: 0, cut: false, ...rendering },
        },
        ...more,
    });

const behindViewer = (): Vec3 => along(cameraOf().eye, -500, orbit.direction);
const cameraOf = (): Camera => orbitCamera({ orbit } as never);

/// Direction of a pixel's ray, from the upper left corner.
const rayOf = (x: number, y: number): Vec3 =>
    rayThrough(
        cameraOf(),
        kOutsideField,
        0,
        (2 * (x + 0.5) - kWidth) / kHeight,
        1 - (2 * (y + 0.5)) / kHeight,
    );

/// Position of a pixel's samples in their steps, in single precision as in the shader.
function offsetOf(x: number, y: number): number {
    const single = Math.fround;
    const place = single(
        single((x + 0.5) * single(0.06711056)) + single((y + 0.5) * single(0.00583715)),
    );
    const noise = single(single(52.9829189) * single(place - Math.floor(place)));
    return noise - Math.floor(noise);
}

const srgbOf = (light: number): number =>
    255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055);

/// Compares each pixel with its ray in JavaScript. @returns mean and largest difference, of 255
function away(
    seen: Uint8Array,
    transfer: Transfer,
    start: (ray: Vec3) => number = () => 0,
): [number, number] {
    let [sum, most] = [0, 0];
    for (let y = 0; y < kHeight; ++y)
        for (let x = 0; x < kWidth; ++x) {
            const ray = rayOf(x, y);
            const eye = along(cameraOf().eye, start(ray), ray);
            const offset = offsetOf(x, kHeight - 1 - y);
            const { light, transmittance } = blendAlong(volume, transfer, eye, ray, offset);
            for (let c = 0; c < 3; ++c) {
                const behind = transmittance * (c === 1 ? linearOf(6) : kFog);
                const expected = srgbOf(Math.min(light[c]! + behind, 1));
                const off = Math.abs(seen[3 * (y * kWidth + x) + c]! - expected);
                sum += off;
                most = Math.max(most, off);
            }
        }
    return [sum / (3 * kWidth * kHeight), most];
}

function near([mean, most]: [number, number]): void {
    assert.ok(mean < 0.4 && most < 8, `mean ${mean}, at most ${most}`);
}

test('bands, glass and opaque surfaces are those of every sample of each ray', async () => {
    for (const transfer of [kBand, kThin, kOpaque]) near(away(await draw({ transfer }), transfer));
});

test('density and shift change extinctions and values', async () => {
    const rendering = { opacity: 0.3, shift: 150 };
    const seen = await draw({ transfer: kBand, rendering });
    near(away(seen, adjusted(kBand, 0.3, 150)));
    const [mean] = away(seen, kBand);
    assert.ok(mean > 2, `mean ${mean}`);
});

test('the cut opens the volume at the plane through the tip', async () => {
    const { grid } = volume;
    const eye = grid.origin.map(
        (x, a) => x + 0.5 * (grid.size[a]! - 1) * grid.spacing[a]!,
    ) as unknown as Vec3;
    const { eye: from, look, up } = cameraOf();
    const right = cross(look, up);
    const depth = eye.reduce((sum, x, a) => sum + (x - from[a]!) * look[a]!, 0);
    // In the same plane, at the scan's border, where the endoscope is out of sight.
    const room = Math.min(
        ...right.map((r, a) => (0.5 * (grid.size[a]! - 1) * grid.spacing[a]!) / Math.abs(r)),
    );
    const tip = along(eye, 0.999 * room, right);
    const seen = await draw({ transfer: kOpaque, rendering: { cut: true }, eye: tip });
    near(away(seen, kOpaque, (ray) => depth / ray.reduce((s, r, a) => s + r * look[a]!, 0)));
});

test('during motion longer steps give nearly the same picture', async () => {
    const transfer = rampOf(-600, 200, 0.2);
    const [mean, most] = away(await draw({ transfer, moving: true }), transfer);
    assert.ok(mean > 0.3 && mean < 4, `mean ${mean}, at most ${most}`);
});

/// Ball with its shaft behind it.
const ball = (centre: Vec3): ToolBall => ({
    centre,
    radius: 6,
    own: false, // its shaft lies behind it, not between it and the viewer
    kind: 'ball',
    direction: mul(-1, cameraOf().look),
});

/// Number of pixels that differ between two pictures.
const changed = (a: Uint8Array, b: Uint8Array): number => different(a, b).filter(Boolean).length;

test('tools hide the tissue behind them, and are hidden by opaque tissue in front', async () => {
    const { eye, look } = cameraOf();
    const place = (share: number): Vec3 => along(eye, share * orbit.distance, look);
    const line = (share: number): Vec3[] =>
        [-12, -4, 4, 12].map((x) => along(place(share), x, [0, 0, 1]));
    for (const [name, front, inside] of [
        ['ball', { balls: [ball(place(0.5))] }, { balls: [ball(place(1))] }],
        ['catheter', { catheter: line(0.5) }, { catheter: line(1) }],
    ] as const) {
        // Behind the viewer: the same program draws all pictures.
        const hidden = [-200, -210].map((mm) => along(eye, mm, look));
        const bare = name === 'ball' ? { balls: [ball(hidden[0]!)] } : { catheter: hidden };
        const opaque = await draw({ transfer: kOpaque, ...bare });
        assert.ok(changed(opaque, await draw({ transfer: kOpaque, ...front })) > 20, name);
        const shown = changed(opaque, await draw({ transfer: kOpaque, ...inside }));
        assert.equal(shown, 0, `${name}: pixels of it are seen`);
        const glass = await draw({ transfer: kThin, ...bare });
        const dim = await draw({ transfer: kThin, ...inside });
        assert.ok(changed(glass, dim) > 20, `${name} in glass`);
    }
});

const rendering = async (): Promise<Rendering> => (await stateOf(page)).rendering;

test('keys and presets show the volume, and each can be undone', async () => {
    await page.keyboard.press('Shift+O');
    assert.equal((await rendering()).preset, 'muscle');
    const { view } = await stateOf(page);
    assert.ok(view.outside && view.blended);
    assert.equal(await page.locator('.view.endoscope .name').textContent(), 'Volume');
    const before_ = await pixels(page, 'endoscope');
    assert.ok(before_.lit > 0.05, `lit ${before_.lit}`);
    await page.locator('summary', { hasText: 'Volume rendering' }).click();
    for (const name of ['bones', 'dark']) {
        await page.locator('.panels button', { hasText: new RegExp(`^${name}$`) }).click();
        assert.equal((await rendering()).preset, name);
        await page.waitForTimeout(800); // else both are one step of undo
    }
    await page.getByLabel('Density, number').fill('2.5');
    await page.getByLabel('Density, number').press('Enter');
    assert.equal((await rendering()).opacity, 2.5);
    const names: string[] = [];
    for (let n = 0; n < 4; ++n) {
        await page.evaluate(() => (window as never as { pliant: Session }).pliant.history.undo());
        const { preset, opacity: factor } = await rendering();
        names.push(`${preset} ${factor}`);
    }
    assert.deepEqual(names, ['dark 1', 'bones 1', 'muscle 1', ' 1']);
    assert.equal((await stateOf(page)).view.outside, false);
});

test('the volume follows the tissue, and a click hits what is seen', async () => {
    await page.evaluate(
        ([transfer, orbit]) =>
            (window as never as { pliant: Session }).pliant.store.set({
                view: { outside: true, blended: true, orbit },
                rendering: { preset: 'test', transfer, opacity: 1, shift: 0 },
            }),
        [rampOf(-800, 0, 0.1), orbit] as const,
    );
    const atRest = await pixels(page, 'endoscope');
    const box = await rectOf(page, 'endoscope');
    await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    const { cursor } = (await stateOf(page)).sections;
    const { picked } = blendAlong(volume, rampOf(-800, 0, 0.1), cameraOf().eye, cameraOf().look);
    const off = Math.hypot(...cursor.map((x, a) => x - picked![a]!));
    assert.ok(off < 1, `the click is ${off} mm away`);
    await page.evaluate(
        (point) =>
            (window as never as { pliant: Session }).pliant.ask({
                do: 'push',
                point,
                push: [0, 8, 0],
                radius: 8,
            }),
        cursor,
    );
    await untilUndo(page, 1);
    await page.waitForTimeout(400);
    assert.notEqual((await pixels(page, 'endoscope')).hash, atRest.hash);
    await page.evaluate(() => (window as never as { pliant: Session }).pliant.ask({ do: 'undo' }));
    await untilUndo(page, 0);
    await page.waitForTimeout(400);
    assert.equal((await pixels(page, 'endoscope')).hash, atRest.hash);
});
