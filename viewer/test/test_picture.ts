// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The browser's picture and the C++ renderer's, of the same camera: on the phantom, at rest and
// deformed, with each table of colours, and, if present, on a CT. They share definitions of camera,
// surface and light, but no code. Bounds, in 0…255: 0.5 on average over all pixels and channels,
// and at most 0.5 % of the pixels off by more than 16 (edges, where the four rays per pixel
// differ). An error of half a degree in the camera exceeds them by far.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import type { Browser } from 'playwright-core';
import type { Vec3 } from '../src/maths/vec.ts';
import { kLinings, type Style } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import { launch, serve, visit } from './browser.ts';
import { difference, type Difference, type Shown } from './picture_difference.ts';
import { kThorax } from './setups.ts';

const program = process.env.PLIANT_SERVER;
const folder = mkdtempSync(join(tmpdir(), 'pliant-picture-'));
let browser: Browser;
before(async () => {
    browser = await launch();
});
after(async () => {
    await browser.close();
    rmSync(folder, { recursive: true });
});

const kMean = 0.5;
const kMaxFar = 0.005;

/// Style, error of the other camera [degrees], other settings.
type Wanted = readonly [Style, number, Shown?];

/// Compares pictures of one scan. @param commands  to the tissue, before the pictures
async function differences(
    scan: string,
    names: Record<string, Wanted>,
    commands: readonly object[] = [],
): Promise<Difference[]> {
    const served = await serve(scan);
    const { page, errors } = await visit(browser, served.link);
    for (const command of commands) {
        const done = await page.evaluate(
            (c) => (window as never as { pliant: Session }).pliant.ask(c as never),
            command,
        );
        assert.ok(done, JSON.stringify(command));
    }
    const found: Difference[] = [];
    for (const [name, [style, off, shown]] of Object.entries(names))
        found.push(await difference(page, scan, name, off, style, shown));
    assert.deepEqual(errors, []);
    await page.context().close();
    await served.stop();
    return found;
}

const bound = ({ mean, far }: Difference): void =>
    assert.ok(mean < kMean && far < kMaxFar, `mean ${mean}, far ${far}`);

/// Writes the airway phantom. @returns its file
function airway(): string {
    const scan = join(folder, 'airway.nrrd');
    if (!existsSync(scan))
        execFileSync(program!, ['phantom', 'airway', '--size', '128', '--out', scan]);
    return scan;
}

test(
    'the phantom looks the same as in C++, but not with an error of half a degree',
    {
        skip: !program,
    },
    async () => {
        const scan = airway();
        const [same, off, real, realOff] = await differences(scan, {
            picture_phantom: ['plain', 0],
            picture_off: ['plain', 0.5],
            picture_phantom_real: ['real', 0],
            picture_real_off: ['real', 0.5],
        });
        bound(same!);
        assert.ok(off!.mean > kMean, `mean ${off!.mean}`);
        bound(real!);
        assert.ok(realOff!.mean > kMean, `mean ${realOff!.mean}`);
    },
);

test('a CT looks the same as in C++', { skip: !program || !existsSync(kThorax) }, async () => {
    const [plain, real] = await differences(kThorax, {
        picture_ct: ['plain', 0],
        picture_ct_real: ['real', 0],
    });
    bound(plain!);
    bound(real!);
});

test(
    'on a slow machine edges become as smooth as in C++, one picture after the other',
    {
        skip: !program,
    },
    async () => {
        const [fine, coarse] = await differences(airway(), {
            picture_passes: ['real', 0, { quality: 2 }],
            picture_one_pass: ['real', 0, { quality: 2, fine: false }],
        });
        bound(fine!);
        assert.ok(coarse!.far > 2 * fine!.far, `far ${coarse!.far} and ${fine!.far}`);
    },
);

test(
    'each lining and each shape of the field looks the same as in C++',
    {
        skip: !program,
    },
    async () => {
        const wanted: Record<string, Wanted> = {};
        for (const lining of kLinings) wanted[`picture_${lining}`] = ['real', 0, { lining }];
        wanted.picture_octagon = ['real', 0, { lining: 'airway', fieldStop: 'octagon' }];
        wanted.picture_full = ['real', 0, { lining: 'airway', fieldStop: 'full' }];
        for (const found of await differences(airway(), wanted)) bound(found);
    },
);

test(
    'tissue that was cut, pushed and carved looks the same as in C++',
    {
        skip: !program,
    },
    async () => {
        const scan = airway();
        const radius = 3;
        // A closed slit in the wall, an open one, and a hole.
        const closed: Vec3[] = [
            [5.5, -4.5, 27],
            [5.5, -4.5, 12],
        ];
        const open: Vec3[] = [
            [-5.5, -4.5, 27],
            [-5.5, -4.5, 12],
        ];
        const depths: Vec3[] = [
            [9, 0, 0],
            [-9, 0, 0],
        ];
        const [point, push]: Vec3[] = [
            [-8, -7, 19],
            [-1, -2.5, 0],
        ];
        const [from, to]: Vec3[] = [
            [1, 6, 17],
            [2, 6, 18],
        ];
        const state = join(folder, 'cut.plst');
        const text = (...points: readonly Vec3[]): string =>
            points.map((p) => p.join(',')).join(';');
        execFileSync(program!, [
            'deform',
            scan,
            `--tool=sphere:${radius}`,
            `--cut=${text(...closed)}:${text(depths[0]!)}`,
            `--cut=${text(...open)}:${text(depths[1]!)}`,
            `--push=${text(point!)}:${text(push!)}`,
            `--carve=${text(from!, to!)}:${radius}`,
            '--solver=sweep', // limits of a box, as a server's tissue has them
            `--out=${join(folder, 'cut.nrrd')}`,
            `--save-state=${state}`,
        ]);
        const commands = [
            { do: 'cut', line: closed, depth: depths[0] },
            { do: 'cut', line: open, depth: depths[1] },
            { do: 'push', point, push, radius },
            { do: 'carve', from, to, radius },
        ];
        const camera = {
            eye: [0.3, -1.8, 36] as Vec3,
            look: [0, -0.1, -1] as Vec3,
            up: [0, -1, -0.1] as Vec3,
        };
        const [plain, real, atRest] = await differences(
            scan,
            {
                picture_cut: ['plain', 0, { camera, state }],
                picture_cut_real: ['real', 0, { camera, state }],
                picture_cut_at_rest: ['real', 0, { camera }],
            },
            commands,
        );
        bound(plain!);
        bound(real!);
        assert.ok(atRest!.mean > kMean, `mean ${atRest!.mean}`);
    },
);
