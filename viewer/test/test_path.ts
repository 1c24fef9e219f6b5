// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { readPath } from '../src/path.ts';
import { dot, norm, sub, type Vec3 } from '../src/vec.ts';
import { launch, kFolder, picture, serve, visit } from './browser.ts';
import type { Session } from '../src/session.ts';

const file = (points: number[][], coordinateSystem: unknown = 'LPS'): string =>
    JSON.stringify({
        markups: [{ coordinateSystem, controlPoints: points.map((position) => ({ position })) }],
    });

test('a path is flown point by point at an even speed', () => {
    const path = readPath(
        file([
            [0, 0, 0],
            [10, 0, 0],
            [10, 30, 0],
        ]),
        'a',
    );
    assert.equal(path.length, 40);
    assert.deepEqual(path.at(5), [5, 0, 0]);
    assert.deepEqual(path.at(25), [10, 15, 0]);
    assert.deepEqual(path.at(99), [10, 30, 0]);
    for (let way = 0; way < 40; way += 1.7) {
        assert.ok(Math.abs(path.nearest(path.at(way)) - way) < 1e-9);
        const { look, up } = path.camera(way, [0, 0, 1]);
        assert.ok(Math.abs(norm(look) - 1) < 1e-9 && Math.abs(dot(look, up)) < 1e-9);
    }
});

test('RAS is turned into LPS, and what is no path is refused with a line', () => {
    for (const system of ['RAS', 0]) {
        const path = readPath(
            file(
                [
                    [1, 2, 3],
                    [4, 5, 6],
                ],
                system,
            ),
            'a',
        );
        assert.deepEqual(path.points[0], [-1, -2, 3]);
    }
    const bad: [string, RegExp][] = [
        ['{', /^x: expected a markups file/],
        ['{}', /^x: expected markups\[0\]/],
        ['null', /^x: expected markups\[0\]/],
        [file([[1, 2, 3]]), /^x: expected two points/],
        [
            file([
                [1, 2, 3],
                [1, 2],
            ]),
            /^x: controlPoints\[1\]\.position: expected three numbers/,
        ],
    ];
    for (const [text, message] of bad)
        assert.throws(
            () => readPath(text, 'x'),
            (e: Error) => message.test(e.message) && !e.message.includes('\n'),
        );
});

const data = process.env.PLIANT_SHARED_DATA ?? join(kFolder, '../../shared/data');
const ct = join(data, 'thorax_ct_256.nrrd');
const left = join(data, 'thorax_airway_path_left.mrk.json');

test(
    'the flight through the airway of a CT reaches its end in the lumen',
    { skip: !process.env.PLIANT_SERVER || !existsSync(ct) },
    async () => {
        const browser = await launch();
        const served = await serve(ct);
        const { page, errors } = await visit(browser, served.link);
        await page.setInputFiles('input[type=file]', left);
        await page.waitForFunction(
            () => (window as never as { pliant: Session }).pliant.store.state.path,
        );
        const values = await page.evaluate(async () => {
            const { store, volume } = (window as never as { pliant: Session }).pliant;
            const session = (window as never as { pliant: Session }).pliant;
            store.set({ speed: 4 });
            const found: number[] = [];
            const eyes: Vec3[] = [];
            store.listen(({ camera }, changed) => {
                if (!changed.has('camera')) return;
                const { grid } = volume!;
                const v = camera.eye.map((x, a) => x - grid.origin[a]!);
                const ijk = grid.direction.map(
                    (axis, a) =>
                        (axis[0] * v[0]! + axis[1] * v[1]! + axis[2] * v[2]!) / grid.spacing[a]!,
                );
                found.push(volume!.sample(ijk as never));
                eyes.push(camera.eye);
            });
            session.togglePath();
            while (store.state.pathFlying) await new Promise((r) => setTimeout(r, 100));
            return { found, end: eyes[eyes.length - 1]! };
        });
        await picture(page, 'path_end');
        const path = readPath(readFileSync(left, 'utf8'), 'left');
        assert.ok(values.found.length > 20, `${values.found.length} places`);
        assert.ok(norm(sub(values.end, path.points[path.points.length - 1]!)) < 0.01);
        const worst = Math.max(...values.found);
        assert.ok(worst < -500, `${worst} HU on the way`);
        assert.deepEqual(errors, []);
        await browser.close();
        await served.stop();
    },
);
