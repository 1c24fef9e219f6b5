// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One test for each row of the table of gestures.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { add, dot, norm, normalized, sub, type Vec3 } from '../src/maths/vec.ts';
import type { SectionName } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import { dragBy, picture, pixels, rectOf, spot, stateOf, still } from './browser.ts';
import { page, useOnePage } from './one_page.ts';

const kSections: readonly SectionName[] = ['axial', 'coronal', 'sagittal'];
const kAxis: Record<SectionName, 0 | 1 | 2> = { axial: 2, coronal: 1, sagittal: 0 };
useOnePage();

async function hover(view: SectionName | 'endoscope'): Promise<void> {
    await page.mouse.move(...(await spot(page, view)));
}
/// Waits until all undos and redos are done.
const settled = (): Promise<void> =>
    page.evaluate(
        () =>
            (window as never as { pliant: { history: { queue: Promise<void> } } }).pliant.history
                .queue,
    );
const focus = (view: string): Promise<void> => page.locator(`.view.${view}`).focus();

test('scroll slices: wheel, up and down, ten with page up and down', async () => {
    for (const view of kSections) {
        const axis = kAxis[view];
        const {
            sections: { cursor },
            scan: { volume },
        } = await stateOf(page);
        const slice = volume!.spacing_mm[axis];
        const at = async (): Promise<number> => (await stateOf(page)).sections.cursor[axis];
        await hover(view);
        await page.mouse.wheel(0, -100);
        await page.waitForTimeout(50);
        assert.ok(Math.abs((await at()) - cursor[axis] - slice) < 1e-6, `${view}: wheel`);
        await focus(view);
        await page.keyboard.press('ArrowDown');
        assert.ok(Math.abs((await at()) - cursor[axis]) < 1e-6, `${view}: down`);
        await page.keyboard.press('PageUp');
        assert.ok(Math.abs((await at()) - cursor[axis] - 10 * slice) < 1e-6, `${view}: page`);
        await page.keyboard.press('PageDown');
        await page.keyboard.press('ArrowUp');
        await page.keyboard.press('ArrowDown');
        assert.ok(norm(sub((await stateOf(page)).sections.cursor, cursor)) < 1e-6);
    }
});

test('window and level: left drag with W or the tool; window with Shift and wheel', async () => {
    const before = await pixels(page, 'axial');
    await hover('axial');
    await page.keyboard.down('w');
    await dragBy(page, await spot(page, 'axial'), [40, 25]);
    await page.keyboard.up('w');
    let state = await stateOf(page);
    assert.equal(state.sections.window, 1500 + 4 * 40);
    assert.equal(state.sections.level, -200 - 4 * 25);
    assert.notEqual((await pixels(page, 'axial')).hash, before.hash);
    await page.click('[data-tool=window]');
    await dragBy(page, await spot(page, 'coronal'), [-40, -25]);
    state = await stateOf(page);
    assert.deepEqual([state.sections.window, state.sections.level], [1500, -200]);
    await page.click('[data-tool=look]');
    await hover('sagittal');
    await page.keyboard.down('Shift');
    await page.mouse.wheel(0, -100);
    await page.keyboard.up('Shift');
    await page.waitForTimeout(50);
    state = await stateOf(page);
    assert.ok(state.sections.window < 1500 && state.sections.level === -200);
    await page.keyboard.press('Control+z');
    assert.equal((await stateOf(page)).sections.window, 1500);
});

test('crosshair: left click and Shift with move, in all four views', async () => {
    for (const view of kSections) {
        const [x, y] = await spot(page, view, 0.56, 0.44);
        const old = (await stateOf(page)).sections.cursor;
        await page.mouse.click(x, y);
        const { cursor } = (await stateOf(page)).sections;
        assert.ok(norm(sub(cursor, old)) > 1, `${view}: click`);
        assert.ok(Math.abs(cursor[kAxis[view]] - old[kAxis[view]]) < 1e-6);
        // The lines of the view's crosshair cross at the click, once they are drawn.
        const line = page.locator(`.view.${view} line.along`).first();
        const box = await rectOf(page, view);
        const off = async () => Math.abs(Number(await line.getAttribute('x1')) - (x - box.x));
        for (let n = 0; n < 40 && (await off()) >= 1; ++n) await page.waitForTimeout(50);
        assert.ok((await off()) < 1, `${view}: line ${await off()} from the click`);
        await page.keyboard.down('Shift');
        await page.mouse.move(x + 30, y + 10);
        await page.keyboard.up('Shift');
        assert.ok(norm(sub((await stateOf(page)).sections.cursor, cursor)) > 1, `${view}: Shift`);
    }
    const old = (await stateOf(page)).sections.cursor;
    await page.mouse.click(...(await spot(page, 'endoscope', 0.2, 0.5)));
    const {
        sections: { cursor },
        view: { camera },
    } = await stateOf(page);
    assert.ok(norm(sub(cursor, old)) > 0.5, 'endoscope: click');
    // The click is on a wall: its value is the threshold.
    const value = await page.evaluate(() => document.querySelector('#pointer')!.textContent!);
    assert.match(value, /HU · LPS .* mm · ijk \d+, \d+, \d+/);
    assert.ok(dot(sub(cursor, camera.eye), camera.look) > 0);
    await picture(page, 'crosshair');
});

test('pan with the middle button; zoom with the right one and Ctrl with the wheel', async () => {
    for (const view of kSections) {
        const before = await pixels(page, view);
        const middle = await spot(page, view);
        await dragBy(page, middle, [30, 12], 'middle');
        const panned = (await stateOf(page)).sections.frames[view];
        assert.ok(panned.shift[0] < 0 && panned.shift[1] > 0, `${view}: pan`);
        await dragBy(page, middle, [0, -40], 'right');
        const zoomed = (await stateOf(page)).sections.frames[view].zoom;
        assert.ok(zoomed > 1.3, `${view}: right drag ${zoomed}`);
        await page.keyboard.down('Control');
        await page.mouse.wheel(0, -100);
        await page.keyboard.up('Control');
        await page.waitForTimeout(50);
        assert.ok((await stateOf(page)).sections.frames[view].zoom > zoomed, `${view}: Ctrl+wheel`);
        assert.notEqual((await pixels(page, view)).hash, before.hash);
    }
    await picture(page, 'zoomed');
    await focus('axial');
    await page.keyboard.press('Home');
    assert.equal((await stateOf(page)).sections.frames.axial.zoom, 1);
    await hover('endoscope');
    await page.keyboard.down('Control');
    await page.mouse.wheel(0, 100);
    await page.keyboard.up('Control');
    await page.waitForTimeout(50);
    assert.ok((await stateOf(page)).view.fieldOfView > 80);
    await page.keyboard.press('Control+z');
});

test('maximise: double click, and V goes through the views', async () => {
    for (const view of [...kSections, 'endoscope'] as const) {
        const small = await rectOf(page, view);
        await page.mouse.dblclick(...(await spot(page, view)));
        const large = await rectOf(page, view);
        assert.ok(large.width > 1.9 * small.width && large.height > 1.9 * small.height, view);
        assert.equal(await page.locator('.view:visible').count(), 1);
        assert.ok((await pixels(page, view)).lit > 0.05);
        await page.mouse.dblclick(...(await spot(page, view)));
        assert.equal(await page.locator('.view:visible').count(), 4);
    }
    const seen = [];
    for (let i = 0; i < 5; ++i) {
        await page.keyboard.press('v');
        seen.push((await stateOf(page)).display.maximised);
    }
    assert.deepEqual(seen, ['endoscope', 'axial', 'coronal', 'sagittal', null]);
});

test('standard views: keypad 1, 3 and 7, with Ctrl from the other side', async () => {
    const expected = {
        Numpad1: [0, 1, 0],
        Numpad3: [1, 0, 0],
        Numpad7: [0, 0, -1],
    } as const;
    const hashes = new Set<number>();
    for (const [key, direction] of Object.entries(expected)) {
        await page.keyboard.press(key);
        let state = await stateOf(page);
        assert.equal(state.view.outside, true);
        assert.deepEqual(state.view.orbit.direction, direction);
        const seen = await pixels(page, 'endoscope');
        assert.ok(seen.lit > 0.05, `${key}: ${seen.lit}`);
        hashes.add(seen.hash);
        await picture(page, `outside_${key}`);
        await page.keyboard.press(`Control+${key}`);
        state = await stateOf(page);
        assert.deepEqual(add(state.view.orbit.direction, direction).map(Math.abs), [0, 0, 0]);
    }
    assert.equal(hashes.size, 3);
    // A click on the cut face, beside the lumen, sets the crosshair there.
    const { camera, orbit: facing } = (await stateOf(page)).view;
    const seenPoint = async (): Promise<Vec3> => (await stateOf(page)).sections.cursor;
    let onFace = 0;
    for (const [u, v] of [
        [0.3, 0.35],
        [0.7, 0.35],
        [0.35, 0.7],
        [0.62, 0.66],
    ] as const) {
        await page.mouse.click(...(await spot(page, 'endoscope', u, v)));
        await page.waitForTimeout(50);
        const point = await seenPoint();
        const value = await page.evaluate((p) => {
            const { volume } = (window as never as { pliant: Session }).pliant;
            const { grid } = volume!;
            const at = p.map((x, a) => (x - grid.origin[a]!) / grid.spacing[a]!);
            return volume!.sample(at as never);
        }, point);
        const off = Math.abs(dot(sub(point, camera.eye), facing.direction));
        if (value > -400 && off < 1e-6) ++onFace;
    }
    assert.ok(onFace >= 2, `${onFace} clicks on the cut face`);
    const { orbit } = (await stateOf(page)).view;
    await dragBy(page, await spot(page, 'endoscope'), [60, 20]);
    assert.notDeepEqual((await stateOf(page)).view.orbit.direction, orbit.direction);
    await page.keyboard.press('o');
    assert.equal((await stateOf(page)).view.outside, false);
});

test('undo and redo: Ctrl+Z and Ctrl+Shift+Z, over camera, window and threshold', async () => {
    const start = await stateOf(page);
    await dragBy(page, await spot(page, 'endoscope'), [50, 10]);
    const turned = await stateOf(page);
    assert.notDeepEqual(turned.view.camera.look, start.view.camera.look);
    await hover('axial');
    await page.keyboard.down('w');
    await dragBy(page, await spot(page, 'axial'), [-20, 0]);
    await page.keyboard.up('w');
    const windowed = await stateOf(page);
    assert.notEqual(windowed.sections.window, start.sections.window);
    const iso = start.shared!.iso_hu;
    await page.keyboard.press('Period');
    await page.waitForFunction(
        (old) => (window as never as { pliant: Session }).pliant.store.state.shared!.iso_hu !== old,
        iso,
    );
    for (let i = 0; i < 3; ++i) {
        await page.keyboard.press('Control+z');
    }
    await settled();
    const undone = await stateOf(page);
    assert.equal(undone.shared!.iso_hu, iso);
    assert.equal(undone.sections.window, start.sections.window);
    assert.deepEqual(undone.view.camera.look, start.view.camera.look);
    for (let i = 0; i < 3; ++i) {
        await page.keyboard.press('Control+Shift+z');
    }
    await settled();
    const redone = await stateOf(page);
    assert.equal(redone.shared!.iso_hu, iso + 25);
    assert.equal(redone.sections.window, windowed.sections.window);
    assert.deepEqual(redone.view.camera.look, turned.view.camera.look);
    for (let i = 0; i < 3; ++i) {
        await page.keyboard.press('Control+z');
    }
});

test('endoscope: W and S fly, the mouse looks, Space stops, walls stop the tip', async () => {
    await focus('endoscope');
    const start = await stateOf(page);
    const moved = (from: Vec3, least: number): Promise<unknown> =>
        page.waitForFunction(
            ([eye, mm]) => {
                const now = (window as never as { pliant: Session }).pliant.store.state.view.camera
                    .eye;
                return Math.hypot(...now.map((x, a) => x - eye[a]!)) > mm;
            },
            [from, least] as const,
        );
    await page.keyboard.down('w');
    await moved(start.view.camera.eye, 2);
    await page.keyboard.press('Space');
    const flown = await stateOf(page);
    const way = sub(flown.view.camera.eye, start.view.camera.eye);
    assert.ok(dot(normalized(way), start.view.camera.look) > 0.9, 'along the view');
    await page.waitForTimeout(400);
    assert.deepEqual(
        (await stateOf(page)).view.camera.eye,
        flown.view.camera.eye,
        'Space has stopped it',
    );
    await page.keyboard.up('w');
    await page.keyboard.down('s');
    await moved(flown.view.camera.eye, 1);
    await page.keyboard.up('s');
    const back = sub((await stateOf(page)).view.camera.eye, flown.view.camera.eye);
    assert.ok(dot(normalized(back), start.view.camera.look) < -0.9, `S flies back: ${back}`);
    // Turn to the wall and fly on: it stops the tip.
    await dragBy(page, await spot(page, 'endoscope', 0.2), [330, 0]);
    await picture(page, 'wall');
    await page.keyboard.down('w');
    await page.waitForTimeout(2500);
    const atWall = (await stateOf(page)).view.camera.eye;
    await page.waitForTimeout(500);
    await page.keyboard.up('w');
    const value = await page.evaluate(() => {
        const { volume, store } = (window as never as { pliant: Session }).pliant;
        const { grid } = volume!;
        const ijk = store.state.view.camera.eye.map(
            (x, a) => (x - grid.origin[a]!) / grid.spacing[a]!,
        );
        return volume!.sample(ijk as never);
    });
    assert.ok(value < start.shared!.iso_hu, `${value} HU at the tip`);
    assert.ok(norm(sub((await stateOf(page)).view.camera.eye, atWall)) < 15);
    await still(page);
});
