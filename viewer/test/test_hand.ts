// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Hand and eye: the sections follow the tool, a probe that is held presses, a scoop keeps its
// depth, the endoscope comes to the crosshair, and outcomes are shown at the tool.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { dot, norm, sub, type Vec3 } from '../src/maths/vec.ts';
import type { SharedState } from '../src/net/protocol.ts';
import type { Session } from '../src/tools/session.ts';
import {
    dragBy,
    picture,
    rectOf,
    serve,
    spot,
    stateOf,
    still,
    untilState,
    untilUndo,
    visit,
} from './browser.ts';
import { browser, page, served, useOnePage } from './one_page.ts';

useOnePage();

type Shown = { pliant: Session };
const cursor = async (): Promise<Vec3> => (await stateOf(page)).sections.cursor;
const steps = async (): Promise<number> => (await stateOf(page)).shared!.undo.steps;
const undo = async (to: number): Promise<void> => {
    for (let n = 0; n < 20 && (await steps()) > to; ++n) {
        await page.keyboard.press('Control+z');
        await page.waitForTimeout(150);
    }
    await untilUndo(page, to);
};
/// Where the ray through a spot of the endoscope's view meets the wall.
const hit = (u: number, v: number): Promise<Vec3> =>
    spot(page, 'endoscope', u, v).then(async ([x, y]) => {
        await page.mouse.move(x, y);
        return (await stateOf(page)).pointer.under!.point;
    });

test('the sections follow a tool in the endoscope while it acts, unless told not to', async () => {
    await page.keyboard.press('3');
    const place = await hit(0.25, 0.5);
    const before = await cursor();
    assert.ok(norm(sub(place, before)) > 3);
    await page.mouse.down();
    await page.waitForTimeout(150);
    assert.ok(norm(sub(await cursor(), place)) < 1e-6, 'pressed');
    const [x, y] = await spot(page, 'endoscope', 0.25, 0.5);
    for (let n = 1; n <= 8; ++n) await page.mouse.move(x + 5 * n, y);
    await untilState(page, ({ shared }) => shared!.undo.steps > 0);
    await page.waitForTimeout(300);
    const tool = await page.evaluate(() => {
        const { hand } = (window as never as Shown).pliant;
        return [...hand.stroke!.path[hand.stroke!.path.length - 1]!] as unknown as Vec3;
    });
    assert.ok(norm(sub(tool, place)) > 1, 'the tool has moved');
    assert.ok(norm(sub(await cursor(), tool)) < 1, 'dragged');
    await picture(page, 'follow');
    await page.mouse.up();
    await undo(0);
    await page.locator('summary', { hasText: /^Tool$/ }).waitFor();
    await page.getByLabel('sections follow the tool').uncheck();
    const rest = await cursor();
    await dragBy(page, [x, y], [30, 0]);
    await untilState(page, ({ shared }) => shared!.undo.steps > 0);
    assert.deepEqual(await cursor(), rest);
    await page.getByLabel('sections follow the tool').check();
    await undo(0);
});

test('a probe that is held still goes into the wall along the ray', async () => {
    await page.keyboard.press('3');
    const place = await hit(0.7, 0.6);
    const { camera } = (await stateOf(page)).view;
    await page.mouse.down();
    await untilState(page, ({ shared }) => shared!.undo.steps > 0, 10);
    await page.waitForTimeout(500);
    const tool = await page.evaluate(() => {
        const { hand } = (window as never as Shown).pliant;
        return [...hand.stroke!.path[hand.stroke!.path.length - 1]!] as unknown as Vec3;
    });
    await picture(page, 'pressed');
    await page.mouse.up();
    const way = sub(tool, place);
    const ray = sub(place, camera.eye);
    assert.ok(norm(way) > 1, `${norm(way)} mm`);
    assert.ok(dot(way, ray) / norm(way) / norm(ray) > 0.99, 'along the ray');
    const after = await steps();
    await page.waitForTimeout(400);
    assert.equal(await steps(), after, 'a released button ends it');
    await undo(0);
});

test('a short click with Push does not press', async () => {
    await page.mouse.click(...(await spot(page, 'endoscope', 0.7, 0.6)));
    await page.waitForTimeout(700);
    assert.equal(await steps(), 0);
});

test('a scoop that wobbles in one place makes a dent of its size, no shaft', async () => {
    await page.evaluate(() =>
        (window as never as Shown).pliant.store.set({ tool: { name: 'carve', radius: 4 } }),
    );
    const [x, y] = await spot(page, 'endoscope', 0.3, 0.6);
    const wall = await hit(0.3, 0.6);
    await page.mouse.down();
    for (let n = 0; n < 24; ++n) {
        await page.mouse.move(x + (n % 2 ? 4 : -4), y + (n % 3) - 1);
        await page.waitForTimeout(60);
    }
    await page.mouse.up();
    await untilState(page, ({ shared }) => shared!.undo.steps > 0);
    await page.waitForTimeout(300);
    await still(page);
    await picture(page, 'carve_wobble');
    const bottom = await hit(0.3, 0.6);
    const depth = norm(sub(bottom, wall));
    assert.ok(depth > 1 && depth < 8, `${depth} mm deep`);
    await undo(0);
    await page.keyboard.press('1');
});

test('a cut is marked in the sections until it is undone', async () => {
    await page.keyboard.press('5');
    const at = await spot(page, 'axial', 0.5, 0.3);
    await dragBy(page, at, [40, 30]);
    await untilState(page, ({ shared }) => shared!.undo.steps > 0);
    await page.locator('.view.axial line.cut').first().waitFor({ state: 'attached' });
    await picture(page, 'cut_marked');
    await undo(0);
    await page.waitForTimeout(300);
    assert.equal(await page.locator('line.cut').count(), 0);
    await page.keyboard.press('1');
});

test('the endoscope comes to the crosshair: key, button, Ctrl with a double click', async () => {
    const eye = async (): Promise<Vec3> => (await stateOf(page)).view.camera.eye;
    const start = await eye();
    const lumen = await page.evaluate(() => {
        const { store } = (window as never as Shown).pliant;
        const { camera } = store.state.view;
        const place = camera.eye.map((x, a) => x + 6 * camera.look[a]!) as unknown as Vec3;
        store.set({ sections: { cursor: place } });
        return place;
    });
    await page.keyboard.press('j');
    assert.ok(norm(sub(await eye(), lumen)) < 1e-6, 'key');
    await page.keyboard.press('Control+z');
    await page.waitForTimeout(100);
    assert.deepEqual(await eye(), start);
    await page.evaluate((place) => {
        (window as never as Shown).pliant.store.set({ sections: { cursor: place } });
    }, lumen);
    await page.getByRole('button', { name: 'Endoscope here' }).click();
    assert.ok(norm(sub(await eye(), lumen)) < 1e-6, 'button');
    // A point in the wall: the eye goes into the lumen beside it, and is free.
    await page.waitForTimeout(100);
    const [x, y] = await spot(page, 'axial', 0.5, 0.5);
    await page.keyboard.down('Control');
    await page.mouse.dblclick(x, y);
    await page.keyboard.up('Control');
    assert.equal((await stateOf(page)).display.maximised, null);
    const now = await eye();
    const isFree = await page.evaluate(
        (place) => !(window as never as Shown).pliant.isInTissue(place),
        now,
    );
    assert.ok(isFree || !served.mock, `${now}`);
});

test('a double click maximises and leaves the crosshair where it was; Esc shows all', async () => {
    const before = await cursor();
    await page.mouse.dblclick(...(await spot(page, 'axial', 0.3, 0.3)));
    assert.equal((await stateOf(page)).display.maximised, 'axial');
    assert.deepEqual(await cursor(), before);
    await page.keyboard.press('Escape');
    assert.equal((await stateOf(page)).display.maximised, null);
});

test('with tools that set points a double click is one click', async () => {
    const at = await spot(page, 'axial', 0.4, 0.4);
    for (const tool of ['9', '7']) {
        await page.keyboard.press(tool);
        await page.mouse.dblclick(...at);
        await page.waitForTimeout(100);
        const { display, marks, way } = await stateOf(page);
        assert.equal(display.maximised, null);
        assert.equal(marks.list.length, 0);
        assert.ok(tool === '9' ? marks.pending.length === 1 : way.from && !way.busy);
        // Nor do slow clicks at one place make a length of nothing.
        await page.waitForTimeout(600);
        await page.mouse.click(...at);
        await page.waitForTimeout(100);
        const later = await stateOf(page);
        assert.equal(later.marks.list.length, 0);
        assert.ok(tool === '9' ? later.marks.pending.length === 1 : later.way.from);
        await page.keyboard.press('Escape');
    }
    await page.keyboard.press('1');
});

test('a number field is left with Enter, with Escape, and by the pointer over a view', async () => {
    const field = page.getByLabel('Size, number');
    const radius = async (): Promise<number> => (await stateOf(page)).tool.radius;
    const tool = async (): Promise<string> => (await stateOf(page)).tool.name;
    await page.keyboard.press('3');
    const before = await radius();
    await field.click();
    await field.fill('7');
    await page.mouse.move(...(await spot(page, 'axial')));
    await page.keyboard.press('4');
    assert.equal(await radius(), 7);
    assert.equal(await tool(), 'grab');
    await field.click();
    await field.fill('9');
    await page.keyboard.press('Escape');
    assert.equal(await radius(), 7, 'given up');
    assert.equal(await field.inputValue(), '7');
    await page.keyboard.press('3');
    assert.equal(await tool(), 'push');
    await field.fill(String(before));
    await page.keyboard.press('Enter');
    assert.equal(await radius(), before);
    await page.keyboard.press('1');
    assert.equal(await tool(), 'look');
});

test('the wheel with Ctrl zooms at the pointer', async () => {
    const at = await spot(page, 'axial', 0.3, 0.35);
    await page.mouse.move(...at);
    const under = async (): Promise<Vec3> => {
        await page.mouse.move(at[0] + 1, at[1]);
        await page.mouse.move(...at);
        return (await stateOf(page)).pointer.under!.point;
    };
    const before = await under();
    await page.keyboard.down('Control');
    for (let n = 0; n < 5; ++n) await page.mouse.wheel(0, -100);
    await page.waitForTimeout(100);
    await page.keyboard.up('Control');
    assert.ok((await stateOf(page)).sections.frames.axial.zoom > 2);
    const off = norm(sub(await under(), before));
    assert.ok(off < 1e-6, `${off} mm`);
    await page.keyboard.press('Home');
});

test('outcomes are shown at the tool and go away; no panel moves', async () => {
    const top = (): Promise<number> =>
        page
            .locator('summary', { hasText: /^Surface$/ })
            .evaluate((e) => e.getBoundingClientRect().y);
    const before = await top();
    const place = await cursor();
    await page.mouse.move(...(await spot(page, 'axial')));
    await page.evaluate((at) => {
        (window as never as Shown).pliant.outcomes.show({
            text: 'stopped by bone, 4 mm behind',
            place: at,
            obstacle: [at[0] + 4, at[1], at[2]],
            isStopped: true,
        });
    }, place);
    const note = page.locator('.view.axial .hand-note');
    await note.waitFor();
    assert.equal(await note.textContent(), 'stopped by bone, 4 mm behind');
    await picture(page, 'outcome');
    const line = page.locator('.view.axial line.along').first();
    const box = (await note.boundingBox())!;
    const axial = await rectOf(page, 'axial');
    const x = axial.x + Number(await line.getAttribute('x1'));
    const beside = Math.min(Math.abs(box.x - x), Math.abs(box.x + box.width - x));
    assert.ok(beside < 40, `${beside} pixels beside the tool`);
    assert.equal(await page.locator('circle.obstacle').count(), 3);
    assert.equal(await top(), before);
    await note.waitFor({ state: 'hidden', timeout: 5000 });
    assert.equal(await page.locator('circle.obstacle').count(), 0);
});

test('after a choice of radio buttons the keyboard works on', async () => {
    await page.getByLabel('pushes').check();
    await page.mouse.move(...(await spot(page, 'endoscope')));
    await page.keyboard.press('4');
    assert.equal((await stateOf(page)).tool.name, 'grab');
    await page.getByLabel('stops').check();
    await page.keyboard.press('1');
    assert.equal((await stateOf(page)).tool.name, 'look');
});

test('after Enter in a number keys are commands again', async () => {
    const field = page.getByLabel('Level, number');
    await field.click();
    await field.fill('-210');
    await page.keyboard.press('Enter');
    await page.keyboard.press('2');
    const { tool, sections } = await stateOf(page);
    assert.deepEqual([tool.name, sections.level], ['window', -210]);
    await page.keyboard.press('1');
});

test('flying goes on when the pointer slips into a section', async () => {
    await page.mouse.move(...(await spot(page, 'endoscope')));
    await page.keyboard.down('s');
    await page.mouse.move(...(await spot(page, 'axial')));
    assert.equal((await stateOf(page)).pointer.active, 'endoscope');
    await page.keyboard.up('s');
    await page.mouse.move(...(await spot(page, 'axial', 0.4)));
    assert.equal((await stateOf(page)).pointer.active, 'axial');
});

test('a fresh scan gets round, springing tissue; the step of that is not undone', async () => {
    const fresh = await serve();
    const { page: first } = await visit(browser, fresh.link);
    const before = (await stateOf(first)).shared as SharedState;
    assert.deepEqual([before.undo.steps, before.materials.limits], [0, 'box']);
    await first.evaluate(() => localStorage.setItem('pliant.tissue', '{}'));
    await first.reload();
    await untilState(
        first,
        ({ shared, link }) =>
            link.status === 'open' && shared!.materials.limits === 'rounded' && shared!.relaxing,
    );
    assert.equal((await stateOf(first)).shared!.undo.steps, 1);
    assert.ok(await first.locator('#undo').isDisabled());
    await first.locator('summary', { hasText: /^Material$/ }).click();
    await first.getByLabel('diamond').check();
    await untilState(first, ({ shared }) => shared!.materials.limits === 'box');
    assert.match(
        await first.evaluate(() => localStorage.getItem('pliant.tissue')!),
        /"limits":"box"/,
    );
    await first.context().close();
    await fresh.stop();
});
