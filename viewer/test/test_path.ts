// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { Path, readPath, writePath } from '../src/maths/path.ts';
import { dot, norm, sub, type Vec3 } from '../src/maths/vec.ts';
import type { Session } from '../src/tools/session.ts';
import { picture, serve, spot, stateOf, still, visit } from './browser.ts';
import { browser, page, useOnePage } from './one_page.ts';
import { kData, kThorax } from './setups.ts';

useOnePage();

const file = (points: number[][], coordinateSystem: unknown = 'LPS'): string =>
    JSON.stringify({
        markups: [{ coordinateSystem, controlPoints: points.map((position) => ({ position })) }],
    });

test('a path is flown at constant speed', () => {
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

test('RAS is converted to LPS, and invalid paths are refused with a line', () => {
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

test('a written path is read again', () => {
    const path = new Path(
        [
            [1.25, -2, 3],
            [4, 5, 6.5],
        ],
        [2, 2.5],
    );
    const again = readPath(writePath(path), 'a');
    assert.deepEqual(again.points, path.points);
    assert.match(writePath(path), /radius 2\.50 mm/);
});

test('the tip and a click, or two clicks, give a path that can be flown', async () => {
    const found = (): Promise<unknown> =>
        page.waitForFunction(() => {
            const { path, busy: pathBusy } = (window as never as { pliant: Session }).pliant.store
                .state.way;
            return path && !pathBusy;
        });
    // From the tip to a wall far ahead.
    await page.locator('.panels').getByRole('button', { name: 'From tip' }).click();
    const start = (await stateOf(page)).view.camera.eye;
    assert.deepEqual((await stateOf(page)).way.from, start);
    assert.equal((await stateOf(page)).tool.name, 'path');
    await page.mouse.click(...(await spot(page, 'endoscope', 0.5, 0.45)));
    await found();
    const first = (await stateOf(page)).way.path!;
    assert.ok(norm(sub(first.points[0]!, start)) < 5, String(first.points[0]));
    assert.ok(first.points.length >= 2 && first.radii.length === first.points.length);

    // Two points: by a click on a section's crosshair, and by Enter at another position.
    const way = first.points;
    await page.evaluate(
        (place) => {
            const { store } = (window as never as { pliant: Session }).pliant;
            store.set({ way: { path: null }, sections: { cursor: place } });
        },
        way[way.length - 1]!,
    );
    await page.waitForTimeout(100);
    const [x, y] = await page.evaluate(() => {
        const drawing = document.querySelector('.view.axial svg')!;
        const box = drawing.getBoundingClientRect();
        const at = (kind: string, key: string): number =>
            Number(drawing.querySelector(`.${kind}`)!.getAttribute(key));
        return [box.left + at('along', 'x1'), box.top + at('across', 'y1')];
    });
    await page.mouse.click(x!, y!);
    assert.ok((await stateOf(page)).way.from);
    await page.evaluate((place) => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({ sections: { cursor: place } });
    }, start);
    await page.locator('.view.axial').focus();
    await page.keyboard.press('Enter');
    await found();
    const second = (await stateOf(page)).way.path!;
    assert.ok(norm(sub(second.points[0]!, way[way.length - 1]!)) < 5);
    assert.ok(norm(sub(second.points[second.points.length - 1]!, start)) < 5);
    assert.ok((await page.locator('.view.axial polyline.way').count()) > 0);

    // The saved file can be opened by other programs.
    const [download] = await Promise.all([
        page.waitForEvent('download'),
        page.locator('.panels .plain').getByRole('button', { name: 'Save' }).click(),
    ]);
    assert.equal(download.suggestedFilename(), 'way.mrk.json');
    const saved = readPath(readFileSync(await download.path(), 'utf8'), 'saved');
    assert.equal(saved.points.length, second.points.length);

    // The path is flown, paused, left by steering, and resumed.
    const flying = async (): Promise<boolean> => (await stateOf(page)).way.flying;
    const at = async (): Promise<number> => (await stateOf(page)).way.position;
    await page.locator('.view.endoscope').focus();
    await page.keyboard.press('n');
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.way.position > 0.3,
    );
    await page.keyboard.press('n');
    assert.equal(await flying(), false);
    const paused = await at();
    await page.waitForTimeout(150);
    assert.equal(await at(), paused);
    await page.keyboard.press('n');
    await page.keyboard.down('ArrowLeft');
    await page.waitForFunction(
        () => !(window as never as { pliant: Session }).pliant.store.state.way.flying,
    );
    await page.keyboard.up('ArrowLeft');
    await page.keyboard.press('n');
    await page.waitForFunction(
        () => !(window as never as { pliant: Session }).pliant.store.state.way.flying,
        undefined,
        { timeout: 60_000 },
    );
    assert.ok(norm(sub((await stateOf(page)).view.camera.eye, second.points.at(-1)!)) < 0.01);

    await page.keyboard.press('o');
    await page.waitForTimeout(100);
    await still(page);
    assert.ok((await page.locator('.view.endoscope polyline.way').count()) > 0);
    await picture(page, 'path_outside');
    await page.keyboard.press('o');

    // A point in tissue is refused with a line, and the path stays.
    await page.evaluate(() => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({ tool: { name: 'path' }, way: { from: [-33, -29, 0] } });
    });
    await page.keyboard.press('Enter');
    await page.waitForFunction(
        () => !(window as never as { pliant: Session }).pliant.store.state.way.busy,
    );
    assert.equal((await stateOf(page)).way.from, null);
    assert.equal((await stateOf(page)).way.path!.points.length, second.points.length);
    const said = (await page.locator('body').textContent()) ?? '';
    assert.match(said, /expected (a position in the|positions in one) lumen/);
});

const left = join(kData, 'thorax_airway_path_left.mrk.json');

test(
    'the flight through the airway of a CT reaches its end in the lumen',
    { skip: !process.env.PLIANT_SERVER || !existsSync(kThorax) },
    async () => {
        const served = await serve(kThorax);
        const { page, errors } = await visit(browser, served.link);
        await page.setInputFiles('input[aria-label="path file"]', left);
        await page.waitForFunction(
            () => (window as never as { pliant: Session }).pliant.store.state.way.path,
        );
        const values = await page.evaluate(async () => {
            const { store, volume } = (window as never as { pliant: Session }).pliant;
            const session = (window as never as { pliant: Session }).pliant;
            store.set({ flight: { speed: 4 } });
            const found: number[] = [];
            const eyes: Vec3[] = [];
            store.listen(({ view: { camera } }, before) => {
                if (camera === before.view.camera) return;
                const { grid } = volume!;
                const v = camera.eye.map((x, a) => x - grid.origin[a]!);
                const ijk = grid.direction.map(
                    (axis, a) =>
                        (axis[0] * v[0]! + axis[1] * v[1]! + axis[2] * v[2]!) / grid.spacing[a]!,
                );
                found.push(volume!.sample(ijk as never));
                eyes.push(camera.eye);
            });
            session.path.toggle();
            while (store.state.way.flying) await new Promise((r) => setTimeout(r, 100));
            return { found, end: eyes[eyes.length - 1]! };
        });
        await picture(page, 'path_end');
        const path = readPath(readFileSync(left, 'utf8'), 'left');
        assert.ok(values.found.length > 20, `${values.found.length} places`);
        assert.ok(norm(sub(values.end, path.points[path.points.length - 1]!)) < 0.01);
        const worst = Math.max(...values.found);
        assert.ok(worst < -500, `${worst} HU on the way`);
        assert.deepEqual(errors, []);
        await page.context().close();
        await served.stop();
    },
);
