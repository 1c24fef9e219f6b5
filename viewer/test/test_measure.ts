// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Marks and measurements in the page: set, moved, listed, saved, and moving with the tissue.

import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import type { Download } from 'playwright-core';
import { rayThrough } from '../src/maths/rays.ts';
import { add, dot, norm, sub, type Vec3 } from '../src/maths/vec.ts';
import type { SectionName } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import { sectionPlane, worldOfPixel } from '../src/views/section_geometry.ts';
import { dragBy, picture, rectOf, spot, stateOf, still, untilState } from './browser.ts';
import { page, useOnePage } from './one_page.ts';

useOnePage();

const kSections = ['axial', 'coronal', 'sagittal'] as const;

const present = (name: string): Promise<Vec3[]> =>
    page.evaluate((own) => {
        const { marks, store } = (window as never as { pliant: Session }).pliant;
        return [...marks.present(store.state.marks.list.find((mark) => mark.name === own)!)];
    }, name) as Promise<Vec3[]>;

const names = async (): Promise<string[]> =>
    (await stateOf(page)).marks.list.map(({ name }) => name);

/// World position of page coordinates in a section, by the geometry of sections alone.
async function worldAt(view: SectionName, [x, y]: [number, number]): Promise<Vec3> {
    const { scan, sections } = await stateOf(page);
    const { size, spacing_mm, origin_mm, direction } = scan.volume!;
    const grid = { size, spacing: spacing_mm, origin: origin_mm, direction };
    const box = await rectOf(page, view);
    const plane = sectionPlane(
        grid,
        view,
        sections.frames[view],
        sections.cursor,
        box.width,
        box.height,
    );
    return worldOfPixel(plane, x - box.x, y - box.y);
}

const panel = (): ReturnType<typeof page.locator> =>
    page.locator('.panels details', { has: page.locator('summary', { hasText: /^Measure$/ }) });

const choose = async (kind: string): Promise<void> => {
    await panel().locator(`button[data-kind=${kind}]`).click();
};

async function downloaded(button: string): Promise<{ name: string; text: string }> {
    const [download] = (await Promise.all([
        page.waitForEvent('download'),
        panel().getByRole('button', { name: button }).click(),
    ])) as [Download, void];
    return {
        name: download.suggestedFilename(),
        text: readFileSync(await download.path(), 'utf8'),
    };
}

test('rulers, angles and points are set by clicks in the sections', async () => {
    await panel().locator('summary').click();
    for (const view of kSections) {
        await choose('ruler');
        assert.equal((await stateOf(page)).tool.name, 'measure');
        const before = (await stateOf(page)).sections.cursor;
        const ends = [await spot(page, view, 0.4, 0.4), await spot(page, view, 0.62, 0.55)];
        for (const end of ends) await page.mouse.click(...end);
        const state = await stateOf(page);
        assert.deepEqual(state.sections.cursor, before); // the crosshair stays
        const mark = state.marks.list[state.marks.list.length - 1]!;
        const worlds = [await worldAt(view, ends[0]!), await worldAt(view, ends[1]!)];
        const points = await present(mark.name);
        assert.ok(points.every((p, n) => norm(sub(p, worlds[n]!)) < 1e-6));
        const mm = norm(sub(worlds[1]!, worlds[0]!));
        const text = `${mm.toFixed(1)} mm`;
        assert.ok((await panel().locator('output').allTextContents()).includes(text), text);
        assert.ok((await page.locator(`.view.${view} text.mark`).allTextContents()).includes(text));
    }
    await choose('angle');
    const corner = await spot(page, 'axial', 0.5, 0.6);
    for (const [dx, dy] of [
        [60, 0],
        [0, 0],
        [0, -50],
    ])
        await page.mouse.click(corner[0] + dx!, corner[1] + dy!);
    const right = await panel().locator('li', { has: page.getByLabel('name of angle 1') });
    assert.equal(await right.locator('output').textContent(), '90.0°');
    await choose('point');
    await page.mouse.click(...(await spot(page, 'coronal', 0.3, 0.3)));
    assert.deepEqual(await names(), ['ruler 1', 'ruler 2', 'ruler 3', 'angle 1', 'point 1']);
    await page.waitForTimeout(100);
    await picture(page, 'measure');
});

test('a click in the endoscope marks the point of the wall that its ray hits', async () => {
    const box = await rectOf(page, 'endoscope');
    const place = await spot(page, 'endoscope', 0.3, 0.45);
    await page.mouse.click(...place);
    const [point] = await present('point 2');
    const u = (2 * (place[0] - box.x) - box.width) / box.height;
    const v = 1 - (2 * (place[1] - box.y)) / box.height;
    const { view } = await stateOf(page);
    const direction = rayThrough(view.camera, view.fieldOfView, view.barrel, u, v);
    const way = sub(point!, view.camera.eye);
    // On the ray, and the value there is the threshold.
    const off = norm(sub(way, direction.map((x) => x * norm(way)) as unknown as Vec3));
    assert.ok(off < 1e-6 * norm(way), `${off}`);
    const { value, iso } = await page.evaluate((p) => {
        const { volume, surface } = (window as never as { pliant: Session }).pliant;
        const { grid } = volume!;
        const q = p.map((x, a) => (x - grid.origin[a]!) / grid.spacing[a]!);
        return { value: volume!.sample(q as never), iso: surface.iso };
    }, point!);
    assert.ok(Math.abs(value - iso) < 2, `${value} HU on the wall`);
    assert.ok((await page.locator('.view.endoscope circle.mark.near').count()) > 0);
});

test('marks are renamed, hidden, visited, moved and deleted; all of it can be undone', async () => {
    const row = (name: string): ReturnType<typeof page.locator> =>
        panel().locator('li', { has: page.getByLabel(`name of ${name}`) });
    const undo = async (): Promise<void> => {
        await page.locator('#undo').click();
        await page.waitForTimeout(50);
    };
    const field = page.getByLabel('name of point 1');
    await field.fill('carina');
    await field.press('Enter');
    assert.ok((await names()).includes('carina'));
    const before = await page.locator('.view.coronal circle.mark').count();
    await row('carina').getByRole('checkbox').uncheck();
    await page.waitForTimeout(50);
    assert.equal(await page.locator('.view.coronal circle.mark').count(), before - 1);
    await undo();
    assert.ok(await row('carina').getByRole('checkbox').isChecked());
    await undo();
    assert.ok((await names()).includes('point 1'));
    await page.locator('#redo').click();
    await page.waitForTimeout(50);
    assert.ok((await names()).includes('carina'));

    const [place] = await present('carina');
    await row('carina').getByRole('button', { name: 'go to' }).click();
    assert.ok(norm(sub((await stateOf(page)).sections.cursor, place!)) < 1e-6);

    // A press on a point and a drag move it.
    await page.waitForTimeout(50);
    const at = await page.evaluate(() => {
        const drawing = document.querySelector('.view.coronal')!;
        const box = drawing.getBoundingClientRect();
        const circle = drawing.querySelector('circle.mark.chosen')!;
        return [
            Math.round(box.left + Number(circle.getAttribute('cx'))),
            Math.round(box.top + Number(circle.getAttribute('cy'))),
        ] as [number, number];
    });
    await dragBy(page, at, [40, 24]);
    const world = await worldAt('coronal', [at[0] + 40, at[1] + 24]);
    assert.ok(norm(sub((await present('carina'))[0]!, world)) < 1e-6);
    await undo();
    assert.ok(norm(sub((await present('carina'))[0]!, place!)) < 1e-6);

    const all = await names();
    await row('carina').getByRole('button', { name: 'delete' }).click();
    assert.equal((await names()).length, all.length - 1);
    await undo();
    assert.deepEqual([...(await names())].sort(), [...all].sort());
    // Esc forgets an incomplete mark.
    await choose('ruler');
    await page.mouse.click(...(await spot(page, 'axial', 0.7, 0.7)));
    assert.equal((await stateOf(page)).marks.pending.length, 1);
    await page.locator('.view.axial').focus();
    await page.keyboard.press('Escape');
    assert.equal((await stateOf(page)).marks.pending.length, 0);
    assert.deepEqual([...(await names())].sort(), [...all].sort());
});

test('the keyboard sets a ruler between two positions of the crosshair', async () => {
    const { cursor } = (await stateOf(page)).sections;
    const count = (await names()).length;
    await page.locator('.view.axial').focus();
    await page.keyboard.press('9');
    await page.keyboard.press('Enter');
    await page.evaluate(
        (place) => {
            const { store } = (window as never as { pliant: Session }).pliant;
            store.set({ sections: { cursor: place } });
        },
        add(cursor, [3, 4, 0]),
    );
    await page.keyboard.press('Enter');
    const list = await names();
    assert.equal(list.length, count + 1);
    const points = await present(list[count]!);
    assert.ok(Math.abs(norm(sub(points[1]!, points[0]!)) - 5) < 1e-6);
    await page.keyboard.press('Control+z');
    assert.equal((await names()).length, count);
    await page.evaluate((place) => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({ sections: { cursor: place } });
    }, cursor);
});

test('a mark on tissue moves with it, and a ruler shows the present length', async () => {
    const { volume } = (await stateOf(page)).scan;
    const far = volume!.landmarks[0]!.point_mm;
    // So deep that the sphere around it is tissue, which moves as a whole.
    const point = add(far, [22, 0, 0]);
    await page.evaluate(
        ([a, b]) => {
            const { marks } = (window as never as { pliant: Session }).pliant;
            marks.choose('ruler');
            marks.click(a as Vec3);
            marks.click(b as Vec3);
        },
        [point, far] as const,
    );
    const list = await names();
    const name = list[list.length - 1]!;
    const motion: Vec3 = [0, 0, 3];
    const done = await page.evaluate(
        async ([at, push]) => {
            const { connection } = (window as never as { pliant: Session }).pliant;
            const answer = await connection.ask({
                do: 'push',
                point: at as Vec3,
                push: push as Vec3,
                radius: 9,
            });
            await connection.ask({ do: 'release' });
            return answer as never as { step: number; step_fraction: number; status: string };
        },
        [point, motion] as const,
    );
    await page.waitForFunction(
        (step) => (window as never as { pliant: Session }).pliant.store.state.shared!.step >= step,
        done.step,
    );
    await page.waitForTimeout(500); // for the rest field
    await still(page);
    const moved = await present(name);
    const rest = (await stateOf(page)).marks.list[list.length - 1]!.rest;
    assert.ok(norm(sub(rest[0]!, point)) < 1e-6, 'the anchor stays');
    if (process.env.PLIANT_SERVER) {
        const way = sub(moved[0]!, point);
        const most = motion.map((x) => x * done.step_fraction) as unknown as Vec3;
        const along = dot(way, most) / dot(most, most);
        assert.ok(along > 0.99 && along < 1.01, `moved by ${way}, pushed by ${most}`);
    }
    // In any case the tissue shown there came from the anchor.
    const offset = await page.evaluate((p) => {
        const { marks } = (window as never as { pliant: Session }).pliant;
        return marks.restOf(p as Vec3);
    }, moved[0]!);
    assert.ok(norm(sub(offset, point)) < 0.02, `${offset}`);
    assert.ok(norm(sub(moved[0]!, point)) > 1);
    const length = norm(sub(moved[1]!, moved[0]!));
    const shown = panel().locator('li', { has: page.getByLabel(`name of ${name}`) });
    assert.equal(await shown.locator('output').textContent(), `${length.toFixed(1)} mm`);
    await picture(page, 'measure_moved');
    // A mark that is set in deformed tissue returns with it.
    await page.evaluate((p) => {
        const { marks } = (window as never as { pliant: Session }).pliant;
        marks.choose('point');
        marks.click(p as Vec3);
    }, moved[0]!);
    await page.locator('.view.axial').focus();
    await page.keyboard.press('Control+z');
    await page.keyboard.press('Control+Shift+z');
    const set = (await names()).at(-1)!;
    await page.evaluate(() =>
        (window as never as { pliant: Session }).pliant.connection.ask({ do: 'reset' }),
    );
    await page.waitForTimeout(500);
    assert.ok(norm(sub((await present(set))[0]!, point)) < 0.1);
    assert.ok(norm(sub((await present(name))[0]!, point)) < 0.02);
});

test('markups and tables are saved and loaded, and marks outlive a reload', async () => {
    const all = (await stateOf(page)).marks.list;
    const markups = await downloaded('Save .mrk.json');
    assert.equal(markups.name, 'marks.mrk.json');
    const table = await downloaded('Save .csv');
    assert.equal(table.name, 'marks.csv');
    for (const { name, text } of [markups, table]) {
        await panel().getByRole('button', { name: 'Delete all' }).click();
        assert.deepEqual(await names(), []);
        const file = join(tmpdir(), `pliant-${process.pid}-${name}`);
        writeFileSync(file, text);
        await page.setInputFiles('input[aria-label="marks file"]', file);
        await untilState(page, ({ marks }) => marks.list.length > 0);
        const again = (await stateOf(page)).marks.list;
        const key = (m: (typeof all)[number]): string => m.name;
        const sorted = (list: typeof all): typeof all =>
            [...list].sort((a, b) => key(a).localeCompare(key(b)));
        sorted(again).forEach((m, n) => {
            const other = sorted(all)[n]!;
            assert.equal(m.name, other.name);
            assert.equal(m.kind, other.kind);
            m.rest.forEach((p, i) => assert.ok(norm(sub(p, other.rest[i]!)) < 0.02));
        });
        assert.equal(again.length, all.length);
    }
    // Other files are refused with a line, and nothing changes.
    const file = join(tmpdir(), `pliant-${process.pid}-bad.mrk.json`);
    writeFileSync(file, '{"markups": [{"type": "Plane"}]}');
    await page.setInputFiles('input[aria-label="marks file"]', file);
    await page.locator('.message', { hasText: 'expected Fiducial' }).waitFor();
    assert.equal((await names()).length, all.length);
    const before = (await names()).sort();
    await page.reload();
    await untilState(page, ({ scan }) => scan.loaded === 1);
    await untilState(page, ({ marks }) => marks.list.length > 0);
    assert.deepEqual((await names()).sort(), before);
});

test('the lumen is measured at the tip and along a path', async () => {
    await panel().locator('summary').click(); // closed by the reload
    await page.getByLabel('lumen at the tip').check();
    await untilState(page, ({ lumen }) => lumen.tip !== null);
    const { tip } = (await stateOf(page)).lumen;
    assert.ok(tip && tip !== 'open');
    assert.ok(tip.inscribed <= tip.equivalent + 0.05 && tip.narrow <= tip.wide);
    assert.ok(tip.equivalent > 5 && tip.equivalent < 30, `${tip.equivalent} mm`);
    assert.match((await panel().locator('dl').textContent())!, /Area[\d.]+ mm²/);
    assert.ok((await page.locator('.view.axial path.lumen').count()) > 0);
    const { eye, look } = (await stateOf(page)).view.camera;
    await page.evaluate(
        async ([from, to]) => {
            const { path, store } = (window as never as { pliant: Session }).pliant;
            await path.click(from as Vec3);
            await path.click(to as Vec3);
            if (!store.state.way.path) throw new Error('no path');
        },
        [eye, add(eye, look.map((x) => 16 * x) as unknown as Vec3)] as const,
    );
    await panel().getByRole('button', { name: 'Lumen along the path' }).click();
    await untilState(page, ({ lumen }) => lumen.along.length > 1 && lumen.share === 1);
    const { along } = (await stateOf(page)).lumen;
    assert.equal(along.length, (await stateOf(page)).way.path!.points.length);
    assert.ok(along.some(({ size }) => size && size.equivalent > 5));
    assert.match(
        (await panel().locator('svg.chart').getAttribute('aria-label'))!,
        /at least [\d.]+ mm/,
    );
    await panel().locator('svg.chart').scrollIntoViewIfNeeded();
    await picture(page, 'measure_lumen');
    // A click on the chart goes to that position of the path.
    const box = (await panel().locator('svg.chart').boundingBox())!;
    await page.mouse.click(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
    const share = await page.evaluate(() => {
        const { way } = (window as never as { pliant: Session }).pliant.store.state;
        return way.position / way.path!.length;
    });
    assert.ok(share > 0.4 && share < 0.5, `at ${share} of the path`);
    await page.getByLabel('lumen at the tip').uncheck();
    await untilState(page, ({ lumen }) => lumen.tip === null);
});

test('bars of scale have the length that they say, and slices are numbered', async () => {
    for (const view of kSections) {
        const bar = page.locator(`.view.${view} path.scale:not(.rim)`);
        const shown = (await page.locator(`.view.${view} text.scale`).textContent())!;
        const mm = Number(shown.split(' ')[0]) * (shown.endsWith('cm') ? 10 : 1);
        assert.equal(Number(await bar.getAttribute('data-mm')), mm);
        // The drawing may be made anew at any time.
        const [left, right] = await page.evaluate((name) => {
            const drawing = document.querySelector(`.view.${name} svg`)!;
            const path = drawing.querySelector<SVGGraphicsElement>('path.scale:not(.rim)')!;
            const { x, width } = path.getBBox();
            const start = drawing.getBoundingClientRect().left + x;
            return [start, start + width];
        }, view);
        const [a, b] = [await worldAt(view, [left!, 300]), await worldAt(view, [right!, 300])];
        assert.ok(Math.abs(norm(sub(a, b)) - mm) < 0.01, `${shown}: ${norm(sub(a, b))} mm`);
        const caption = (await page.locator(`.view.${view} .caption`).textContent())!;
        const found = / · slice (\d+) of (\d+)$/.exec(caption);
        assert.ok(found, caption);
        const { scan, sections } = await stateOf(page);
        const a2 = ['sagittal', 'coronal', 'axial'].indexOf(view);
        const { origin_mm, spacing_mm, size } = scan.volume!;
        const index = Math.round((sections.cursor[a2]! - origin_mm[a2]!) / spacing_mm[a2]!);
        assert.deepEqual(found.slice(1).map(Number), [index + 1, size[a2]]);
    }
});
