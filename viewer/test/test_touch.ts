// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Fingers: a test for each gesture, and the layout of small and large windows.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { dot, norm, sub } from '../src/maths/vec.ts';
import { kViews } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import {
    kFolder,
    launch,
    picture,
    rectOf,
    serve,
    type Served,
    spot,
    stateOf,
    still,
    untilState,
    untilUndo,
    visit,
} from './browser.ts';
import { type Spot, Touch } from './touch.ts';

let browser: Browser;
let served: Served;
let page: Page;
let touch: Touch;
const kPhone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true };

before(async () => {
    browser = await launch();
    served = await serve();
    ({ page } = await visit(browser, served.link, '&notour', kPhone));
    touch = await Touch.on(page);
});
after(async () => {
    await browser.close();
    await served.stop();
});

const beside = ([x, y]: readonly number[], dx: number, dy = 0): Spot => [x! + dx, y! + dy];
const tool = (name: string): Promise<void> => page.tap(`[data-tool=${name}]`);

test('one finger scrolls the slices of a section, by whole voxels', async () => {
    const start = await stateOf(page);
    const at = await spot(page, 'axial');
    await touch.drag([at], [beside(at, 0, -48)]);
    const { cursor } = (await stateOf(page)).sections;
    const moved = sub(cursor, start.sections.cursor);
    const slice = start.scan.volume!.spacing_mm[2];
    assert.ok(Math.abs(moved[0]) + Math.abs(moved[1]) < 1e-6, `${moved}`);
    assert.ok(Math.abs(moved[2] / slice - 6) < 1.01, `${moved[2] / slice} slices`);
    await touch.drag([at], [beside(at, 0, 48)]);
    assert.ok(norm(sub((await stateOf(page)).sections.cursor, start.sections.cursor)) < 1e-3);
});

test('a tap sets the crosshair', async () => {
    const { cursor } = (await stateOf(page)).sections;
    await touch.tap(await spot(page, 'coronal', 0.6, 0.45));
    assert.ok(norm(sub((await stateOf(page)).sections.cursor, cursor)) > 1);
});

test('two fingers zoom a section about their middle, and pan it', async () => {
    const at = await spot(page, 'sagittal', 0.4, 0.4);
    const under = (): Promise<number[]> =>
        page.evaluate(async ([x, y]) => {
            const view = document.querySelector('.view.sagittal')!;
            const settings = { clientX: x!, clientY: y!, bubbles: true, pointerId: 77 };
            view.dispatchEvent(new PointerEvent('pointermove', settings));
            const { pointer } = (window as never as { pliant: Session }).pliant.store.state;
            return [...pointer.under!.point];
        }, at);
    const before = await under();
    await touch.drag([beside(at, -20), beside(at, 20)], [beside(at, -50), beside(at, 50)]);
    const { zoom } = (await stateOf(page)).sections.frames.sagittal;
    assert.ok(zoom > 2 && zoom < 3, `${zoom}`);
    const off = norm(sub((await under()) as never, before as never));
    assert.ok(off < 1.5, `${off} mm`);
    const { shift } = (await stateOf(page)).sections.frames.sagittal;
    await touch.drag([beside(at, -20), beside(at, 20)], [beside(at, 0, 30), beside(at, 40, 30)]);
    const panned = (await stateOf(page)).sections.frames.sagittal;
    assert.ok(panned.shift[0] < shift[0] && panned.shift[1] > shift[1], `${panned.shift}`);
    assert.ok(Math.abs(panned.zoom / zoom - 1) < 0.1);
    await page.tap('#undo');
    await page.tap('#undo');
    assert.equal((await stateOf(page)).sections.frames.sagittal.zoom, 1);
});

test('in the endoscope one finger looks around, and two change the field of view', async () => {
    const at = await spot(page, 'endoscope');
    const before = (await stateOf(page)).view;
    await touch.drag([at], [beside(at, 50, 10)]);
    const turned = (await stateOf(page)).view;
    assert.ok(dot(turned.camera.look, before.camera.look) < 0.999);
    assert.deepEqual(turned.camera.eye, before.camera.eye);
    await touch.drag([beside(at, -20), beside(at, 20)], [beside(at, -30), beside(at, 30)]);
    assert.ok((await stateOf(page)).view.fieldOfView < before.fieldOfView - 5);
});

test('the stick flies ahead and back, and turns', async () => {
    const box = (await page.locator('.stick').boundingBox())!;
    const middle: Spot = [box.x + box.width / 2, box.y + box.height / 2];
    const eye = async () => (await stateOf(page)).view.camera;
    const start = await eye();
    await touch.press(middle);
    await touch.move(beside(middle, 0, 30));
    for (let n = 0; n < 100 && norm(sub((await eye()).eye, start.eye)) < 1; ++n)
        await page.waitForTimeout(50);
    await touch.lift();
    const back = await eye();
    assert.ok(dot(sub(back.eye, start.eye), start.look) < -0.9, 'back');
    await page.waitForTimeout(100);
    assert.deepEqual((await eye()).eye, (await eye()).eye, 'a lifted finger stops it');
    await touch.press(middle);
    await touch.move(beside(middle, 0, -30));
    for (let n = 0; n < 100 && norm(sub((await eye()).eye, back.eye)) < 1; ++n)
        await page.waitForTimeout(50);
    await touch.lift();
    assert.ok(dot(sub((await eye()).eye, back.eye), back.look) > 0.9, 'ahead');
    await touch.press(middle);
    await touch.move(beside(middle, 30));
    for (let n = 0; n < 100 && dot((await eye()).look, back.look) > 0.99; ++n)
        await page.waitForTimeout(50);
    await touch.lift();
    assert.ok(dot((await eye()).look, back.look) < 0.99, 'turned');
    await picture(page, 'touch_stick');
});

test('a finger that holds still with Push presses into the wall', async () => {
    const steps = (await stateOf(page)).shared!.undo.steps;
    await tool('push');
    const at = await spot(page, 'endoscope', 0.3, 0.3);
    await touch.press(at);
    await untilState(page, ({ shared }) => (shared?.undo.steps ?? 0) > 0);
    await page.waitForTimeout(400);
    await picture(page, 'touch_press');
    await touch.lift();
    await untilUndo(page, steps + 1);
    await page.tap('#undo');
    await untilUndo(page, steps);
});

test('a second finger ends a stroke and zooms', async () => {
    const at = await spot(page, 'axial', 0.5, 0.5);
    await touch.press(at);
    await touch.press(at, beside(at, 40));
    await touch.move(beside(at, -10), beside(at, 50));
    await touch.lift();
    assert.ok((await stateOf(page)).sections.frames.axial.zoom > 1.2);
    assert.equal((await stateOf(page)).shared!.undo.steps, 0);
    await tool('look');
});

test('each view has a button that maximises it, and back', async () => {
    await page.tap('.view.coronal .maximise');
    assert.equal((await stateOf(page)).display.maximised, 'coronal');
    await page.tap('.view.coronal .maximise');
    assert.equal((await stateOf(page)).display.maximised, null);
});

test('panels are a drawer that a button opens and closes', async () => {
    const panels = page.locator('.panels');
    assert.ok(!(await panels.isVisible()));
    await page.tap('#settings');
    assert.ok(await panels.isVisible());
    await picture(page, 'touch_panels');
    await page.tap('#settings');
    assert.ok(!(await panels.isVisible()));
});

const kSizes = [
    [360, 740],
    [390, 844],
    [844, 390],
    [1024, 768],
    [1440, 900],
    [2560, 1440],
] as const;

for (const [width, height] of kSizes)
    test(`at ${width}×${height} nothing is cut off, and fingers find all buttons`, async () => {
        await page.setViewportSize({ width, height });
        await still(page);
        const [wide, high] = await page.evaluate(() => [
            document.documentElement.scrollWidth,
            document.documentElement.scrollHeight,
        ]);
        assert.ok(wide! <= width && high! <= height, `${wide}×${high}`);
        for (const view of kViews) {
            const box = await rectOf(page, view);
            assert.ok(box.width > 120 && box.height > 180, `${view}: ${box.width}×${box.height}`);
        }
        for (const id of ['#open', '#undo', '#redo', '[data-tool=look]']) {
            const box = (await page.locator(id).boundingBox())!;
            assert.ok(box.x >= 0 && box.x + box.width <= width, `${id} is cut off`);
        }
        const small = await page.evaluate(() =>
            [...document.querySelectorAll('button')]
                .filter((b) => b.offsetWidth && (b.offsetWidth < 40 || b.offsetHeight < 40))
                .map((b) => `${b.textContent}: ${b.offsetWidth}×${b.offsetHeight}`),
        );
        assert.deepEqual(small, []);
        await picture(page, `size_${width}x${height}`);
    });

test('axe finds nothing, in light and dark, with all panels open', async () => {
    const axe = readFileSync(join(kFolder, 'node_modules/axe-core/axe.min.js'), 'utf8');
    const settings = { viewport: { width: 1440, height: 900 }, bypassCSP: true };
    const desk = await visit(browser, served.link, '&notour', settings);
    const phone = await visit(browser, served.link, '&notour', { ...kPhone, bypassCSP: true });
    await phone.page.tap('#settings');
    for (const at of [desk.page, phone.page]) {
        await at.evaluate(axe);
        for (const theme of ['light', 'dark'] as const) {
            const found = await at.evaluate(async (wanted) => {
                const { pliant, axe: checks } = window as never as {
                    pliant: Session;
                    axe: { run(): Promise<{ violations: { id: string; nodes: unknown[] }[] }> };
                };
                pliant.store.set({ display: { theme: wanted } });
                for (const d of document.querySelectorAll('details')) d.open = true;
                const { violations } = await checks.run();
                return violations.map(({ id, nodes }) => `${id}: ${JSON.stringify(nodes[0])}`);
            }, theme);
            assert.deepEqual(found, [], theme);
        }
        await at.context().close();
    }
});
