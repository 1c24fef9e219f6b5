// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A pushing tip: through a phantom with thick slices and, if present, through the shared scans.
// After every step the eye is outside of tissue in the page's mirror of the volume. Only with the
// program's server: the mock doesn't slide.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import type { Vec3 } from '../src/maths/vec.ts';
import type { Materials } from '../src/net/settings.ts';
import type { Session } from '../src/tools/session.ts';
import { kFolder, launch, picture, serve, stateOf, visit } from './browser.ts';

const program = process.env.PLIANT_SERVER;
const kShared = process.env.PLIANT_SHARED_DATA ?? join(kFolder, '../../shared/data');

interface Flight {
    readonly name: string;
    readonly scan: string; ///< file; empty: the phantom with thick slices
    readonly eye: Vec3; ///< in the lumen
    readonly way: Vec3; ///< of one step [mm]
    readonly tip?: number; ///< [mm]; absent: the page's default
    readonly materials?: Partial<Materials>;
    readonly iso?: number; ///< [HU]
}

// As in scenes/thesis.toml.
const kThesis = {
    offset: 0.2,
    bone_threshold_hu: 3000,
    max_movement_mm: 20,
    scale: 1.2,
    air_enabled: false,
} as Partial<Materials>;
const kTrachea: Vec3 = [-15.5, 132.8, -429.3];
const kFlights: readonly Flight[] = [
    { name: 'thick', scan: '', eye: [0, -1.6, 35], way: [0.8, 0, 0] },
    {
        name: 'thick_thesis',
        scan: '',
        eye: [0, -1.6, 35],
        way: [0.8, 0, 0],
        materials: kThesis,
    },
    {
        name: 'thorax',
        scan: 'thorax_ct_256.nrrd',
        eye: kTrachea,
        way: [-0.5, 0, 0],
        tip: 0.7,
    },
    {
        name: 'head',
        scan: 'head_ct_tiny_64.nrrd',
        eye: [99.2, 53.6, 82.8],
        way: [0.4, 0.3, 0],
        materials: { bone_threshold_hu: 1000 },
        iso: -200, // the nose of figure 5.9
    },
];

let browser: Browser;
let folder: string;
before(async () => {
    if (!program) return;
    browser = await launch();
    folder = mkdtempSync(join(tmpdir(), 'pliant-contact-'));
    execFileSync(program, [
        ...['phantom', 'airway', '--size', '160x160x26', '--spacing', '0.8,0.8,5'],
        ...['--out', join(folder, 'thick.nrrd')],
    ]);
});
after(async () => {
    if (!program) return;
    await browser.close();
    rmSync(folder, { recursive: true });
});

/// Value of the page's mirror of the deformed volume at the eye [HU].
const valueAt = (page: Page, place: Vec3): Promise<number> =>
    page.evaluate((at) => {
        const { volume } = (window as never as { pliant: Session }).pliant;
        const { grid } = volume!;
        const from = at.map((v, a) => v - grid.origin[a]!);
        const ijk = grid.direction.map(
            (d, a) => d.reduce((sum, v, b) => sum + v * from[b]!, 0) / grid.spacing[a]!,
        );
        return volume!.sample(ijk as never);
    }, place);

/// Makes a step and waits for the server's answers. @returns the value at the eye [HU]
async function step(page: Page, way: Vec3): Promise<number> {
    await page.evaluate(async (motion) => {
        const session = (window as never as { pliant: Session }).pliant;
        if (motion.some((x) => x !== 0)) session.endoscope.fly(motion);
        // Answers are ordered: the voxels of a push arrive before the answer to the next command.
        for (let n = 0; n < 2; ++n) await session.connection.ask({ do: 'checksum' });
    }, way);
    return valueAt(page, (await stateOf(page)).view.camera.eye);
}

for (const flight of kFlights) {
    const file = join(kShared, flight.scan);
    const skip = !program || (flight.scan !== '' && !existsSync(file));
    test(`the eye is never in tissue: ${flight.name}`, { skip }, async () => {
        const served = await serve(flight.scan ? file : join(folder, 'thick.nrrd'));
        const { page, errors } = await visit(browser, served.link);
        await page.getByLabel('pushes').check();
        await page.evaluate(async ({ eye, way, tip, materials, iso }: Flight) => {
            const session = (window as never as { pliant: Session }).pliant;
            if (materials) await session.ask({ do: 'materials', ...materials });
            if (iso) await session.ask({ do: 'iso', iso_hu: iso });
            if (tip) session.store.set({ flight: { tip } });
            session.endoscope.goTo(eye, way);
        }, flight);
        const start = await stateOf(page);
        const iso = flight.iso ?? start.shared!.iso_hu;
        for (let n = 0; n < 40; ++n) {
            const value = await step(page, flight.way);
            assert.ok(value < iso, `step ${n}: ${value} HU at the eye`);
        }
        const end = await stateOf(page);
        await picture(page, `contact_${flight.name}`);
        assert.ok(end.shared!.undo.steps > 0, 'nothing was pushed');
        for (const button of ['Relax', 'Let go']) {
            await page.getByRole('button', { name: button, exact: true }).click();
            for (let n = 0; n < 10; ++n) {
                const value = await step(page, [0, 0, 0]);
                assert.ok(value < iso, `${button}: ${value} HU at the eye`);
                await page.waitForTimeout(100);
            }
        }
        assert.deepEqual(errors, []);
        await page.context().close();
        await served.stop();
    });
}

test('tissue that relaxes does not close over an eye in a dent', { skip: !program }, async () => {
    const served = await serve(join(folder, 'thick.nrrd'));
    const { page } = await visit(browser, served.link);
    await page.evaluate(async () => {
        const session = (window as never as { pliant: Session }).pliant;
        const point = [8, -1.6, 35] as const;
        await session.ask({ do: 'push', point, push: [5, 0, 0], radius: 4 });
        session.endoscope.goTo([9.5, -1.6, 35], [1, 0, 0]);
    });
    assert.ok((await step(page, [0, 0, 0])) < -500, 'the eye is in the dent');
    for (const button of ['Relax', 'Let go']) {
        await page.getByRole('button', { name: button, exact: true }).click();
        for (let n = 0; n < 15; ++n) {
            const value = await step(page, [0, 0, 0]);
            assert.ok(value < -500, `${button}: ${value} HU at the eye`);
            await page.waitForTimeout(100);
        }
    }
    const { camera } = (await stateOf(page)).view;
    await picture(page, 'contact_dent');
    // The tissue moves around the eye, and doesn't carry it along.
    assert.deepEqual(camera.eye, [9.5, -1.6, 35]);
    await page.evaluate(() =>
        (window as never as { pliant: Session }).pliant.endoscope.goTo([0, -1.6, 35], [1, 0, 0]),
    );
    let left = -1000;
    for (let n = 0; n < 60 && left < -500; ++n) {
        await page.waitForTimeout(100);
        left = await valueAt(page, [9.5, -1.6, 35]);
    }
    assert.ok(left > -500, `without an eye the dent closes: ${left} HU`);
    await page.context().close();
    await served.stop();
});
