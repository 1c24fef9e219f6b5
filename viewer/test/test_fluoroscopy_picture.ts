// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Fluoroscopy in the browser and in the C++ renderer, of the same camera, on the phantom and, if
// present, on CTs, one of them cropped: the mean difference is less than 0.5 of 255, with the same
// noise in every pixel.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import type { Fluoro, Orbit } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import { planesOf } from '../src/views/planes.ts';
import { kPictures, launch, picture, rectOf, serve, stateOf, still, visit } from './browser.ts';
import { pixelDifference } from './picture_difference.ts';
import { kAorta, kThorax } from './setups.ts';

const program = process.env.PLIANT_SERVER;
const kMean = 0.5; // of 255

interface Kind {
    readonly fluoro?: Partial<Fluoro>;
    readonly look?: Orbit['direction'];
    readonly seed?: number; ///< of the C++ renderer
    readonly plane?: 0 | 1; ///< of two planes; absent: there is one
}

/// Mean difference of both pictures, of 255.
async function compare(page: Page, scan: string, name: string, kind: Kind): Promise<number> {
    await page.evaluate(({ fluoro, look, plane }) => {
        const { store } = (window as never as { pliant: Session }).pliant;
        const { orbit } = store.state.view;
        const direction = look ?? orbit.direction;
        store.set({
            view: { outside: true, fluoroscopy: true, orbit: { ...orbit, direction } },
            fluoro: { field: 'round', noise: 1, biplane: plane !== undefined, ...fluoro },
        });
    }, kind);
    await page.waitForTimeout(300);
    await still(page);
    const state = await stateOf(page);
    const { fluoro } = state;
    const box = await rectOf(page, 'endoscope');
    const whole = { width: Math.round(box.width), height: Math.round(box.height) };
    const { view, x, width, height } = planesOf(state, whole)[kind.plane ?? 0]!;
    const { orbit } = view;
    const shown = (2 * orbit.distance * Math.tan(Math.PI / 12) * width) / height;
    const file = join(kPictures, `${name}_cpp.png`);
    execFileSync(program!, [
        'render',
        scan,
        `--out=${file}`,
        '--view=fluoroscopy',
        `--at=${orbit.centre.join(',')}`,
        `--look=${orbit.direction.join(',')}`,
        `--up=${orbit.up.join(',')}`,
        `--source=${orbit.distance}`,
        `--width=${shown}`,
        `--size=${width}x${height}`,
        `--field=${fluoro.field}`,
        `--noise=${fluoro.noise}`,
        `--contrast=${fluoro.contrast}`,
        `--seed=${kind.seed ?? 0}`,
    ]);
    await picture(page, `${name}_browser`);
    const { mean } = await pixelDifference(page, file, x);
    console.log(`# ${name}: mean ${mean.toFixed(3)}`);
    return mean;
}

async function compareAll(scan: string, kinds: Record<string, Kind>): Promise<number[]> {
    const browser = await launch();
    const served = await serve(scan);
    const { page, errors } = await visit(browser, served.link);
    const found: number[] = [];
    for (const [name, kind] of Object.entries(kinds))
        found.push(await compare(page, scan, `fluoroscopy_${name}`, kind));
    await browser.close();
    await served.stop();
    assert.deepEqual(errors, []);
    return found;
}

test('fluoroscopy of the phantom looks the same as in C++', { skip: !program }, async () => {
    const folder = mkdtempSync(join(tmpdir(), 'pliant-fluoroscopy-'));
    const scan = join(folder, 'airway.nrrd');
    execFileSync(program!, ['phantom', 'airway', '--size', '96', '--out', scan]);
    const [round, octagon, full, otherNoise, first, second] = await compareAll(scan, {
        phantom: {},
        octagon: { fluoro: { field: 'octagon', contrast: 2.5 } },
        full: { fluoro: { field: 'full', noise: 0, contrast: 1 } },
        other_noise: { fluoro: { field: 'full' }, seed: 1 },
        first_plane: { plane: 0 },
        second_plane: { plane: 1, seed: 1 },
    }).finally(() => rmSync(folder, { recursive: true }));
    for (const mean of [round, octagon, full, first, second])
        assert.ok(mean! < kMean, `mean ${mean}`);
    assert.ok(otherNoise! > 2 * kMean, `mean ${otherNoise}: the noise is not compared`);
});

test(
    'fluoroscopy of a CT looks the same as in C++',
    {
        skip: !program || !existsSync(kThorax),
    },
    async () => {
        const [mean] = await compareAll(kThorax, { ct: {} });
        assert.ok(mean! < kMean, `mean ${mean}`);
    },
);

test(
    'beyond the border of a cut scan fluoroscopy looks the same as in C++',
    {
        skip: !program || !existsSync(kAorta),
    },
    async () => {
        const found = await compareAll(kAorta, {
            cut: {},
            cut_oblique: { look: [0.707, 0.507, -0.493] },
        });
        for (const mean of found) assert.ok(mean < kMean, `mean ${mean}`);
    },
);
