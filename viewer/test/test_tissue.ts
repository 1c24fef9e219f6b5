// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Changes of the tissue: all four views show them, undo restores the checksum, other clients see
// the same, and lost connections and contexts are restored.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import type { SharedState } from '../src/net/protocol.ts';
import { kViews, type ToolName, type ViewName } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import {
    compare,
    dragBy,
    loaded,
    picture,
    pixels,
    spot,
    stateOf,
    still,
    untilState,
    untilUndo,
    visit,
} from './browser.ts';
import { browser, page, served, useOnePage } from './one_page.ts';

useOnePage({ name: 'Anna' });

type Pictures = Record<ViewName, number>;
async function all(at: Page): Promise<Pictures> {
    const hashes = {} as Pictures;
    for (const view of kViews) hashes[view] = (await pixels(at, view)).hash;
    return hashes;
}
const undoSteps = async (): Promise<number> => (await stateOf(page)).shared!.undo.steps;
const idle = (at: Page): Promise<unknown> =>
    at.evaluate(() =>
        (window as never as { pliant: Session }).pliant.connection.ask({ do: 'checksum' }),
    );
/// Presses Ctrl+Z until the server has a number of steps; own steps of the page are undone as well.
const undo = async (steps: number): Promise<void> => {
    for (let i = 0; i < 30 && (await undoSteps()) > steps; ++i) {
        await page.keyboard.press('Control+z');
        await page.evaluate(
            () =>
                (window as never as { pliant: { history: { queue: Promise<void> } } }).pliant
                    .history.queue,
        );
    }
    await untilUndo(page, steps);
};

/// Sets the crosshair on the wall of the lumen, right of the tip in the axial section.
async function cursorToWall(): Promise<void> {
    await page.evaluate(() => {
        const session = (window as never as { pliant: Session }).pliant;
        const {
            view: { camera },
            shared,
        } = session.store.state;
        const { volume } = session;
        const { grid } = volume!;
        let x = camera.eye[0];
        const value = (): number =>
            volume!.sample(
                [x, camera.eye[1], camera.eye[2]].map(
                    (v, a) => (v - grid.origin[a]!) / grid.spacing[a]!,
                ) as never,
            );
        while (value() < shared!.iso_hu) x += 0.25;
        session.store.set({ sections: { cursor: [x, camera.eye[1], camera.eye[2]] } });
    });
}

/// Position of the crosshair in a view.
async function cursorSpot(view: ViewName): Promise<[number, number]> {
    await page.waitForTimeout(100);
    const box = (await page.locator(`.view.${view}`).boundingBox())!;
    const x = await page.locator(`.view.${view} line.along`).first().getAttribute('x1');
    const y = await page.locator(`.view.${view} line.across`).first().getAttribute('y1');
    return [Math.round(box.x + Number(x)), Math.round(box.y + Number(y))];
}

const kDrags: readonly { tool: ToolName; view: ViewName; by: [number, number] }[] = [
    { tool: 'push', view: 'axial', by: [-25, 0] },
    { tool: 'push', view: 'endoscope', by: [40, 10] },
    { tool: 'grab', view: 'coronal', by: [-20, -8] },
    { tool: 'carve', view: 'sagittal', by: [20, 10] },
    { tool: 'cut', view: 'axial', by: [25, 15] },
];
test("the scan is shown in four views, and its voxels are the server's", async () => {
    for (const view of kViews) {
        const { lit } = await pixels(page, view);
        assert.ok(lit > 0.15, `${view}: ${lit} of the pixels are lit`);
    }
    await picture(page, 'loaded');
    assert.equal((await compare(page))?.same, true);
});

for (const { tool, view, by } of kDrags)
    test(`${tool} in the ${view} view changes voxels; undo brings the checksum back`, async () => {
        await cursorToWall();
        // The crosshair stays, so that pictures before and after can be compared.
        await page.evaluate(() =>
            (window as never as { pliant: Session }).pliant.store.set({
                tool: { radius: 5, follow: false },
            }),
        );
        const steps = await undoSteps();
        const sum = await compare(page);
        assert.equal(sum?.same, true);
        const from =
            view === 'endoscope' ? await spot(page, view, 0.25, 0.5) : await cursorSpot(view);
        const start = await all(page);
        await page.click(`[data-tool=${tool}]`);
        await dragBy(page, from, by);
        await page.waitForFunction(
            (n) =>
                (window as never as { pliant: Session }).pliant.store.state.shared!.undo.steps > n,
            steps,
        );
        await idle(page);
        await page.click('[data-tool=look]');
        const changed = await compare(page);
        assert.equal(changed?.same, true);
        // Cut links alone move nothing; the mock's blade leaves a gap.
        if (tool !== 'cut' || served.mock) assert.notEqual(changed?.own, sum?.own);
        assert.notEqual(changed?.tissue, sum?.tissue);
        const end = await all(page);
        const differ = kViews.filter((v) => start[v] !== end[v]);
        await picture(page, `${tool}_${view}`);
        if (tool === 'push' && view === 'axial') assert.deepEqual(differ, [...kViews]);
        else if (tool !== 'cut' || served.mock) assert.ok(differ.length > 0, 'no view has changed');
        await undo(steps);
        const back = await compare(page);
        assert.equal(back?.same, true);
        assert.equal(back?.own, sum?.own);
        assert.equal(back?.tissue, sum?.tissue);
        assert.deepEqual(await all(page), start);
    });

test('a drag on the cut face of the outside view moves the tissue there', async () => {
    const steps = await undoSteps();
    const sum = await compare(page);
    await page.keyboard.press('Numpad1');
    await page.click('[data-tool=push]');
    // Beside the lumen: its rays begin in tissue.
    await dragBy(page, await spot(page, 'endoscope', 0.7, 0.35), [-30, 10]);
    await untilState(page, ({ shared }) => shared!.undo.steps > steps);
    await idle(page);
    await picture(page, 'push_cut_face');
    assert.notEqual((await compare(page))?.tissue, sum?.tissue);
    await page.click('[data-tool=look]');
    await page.keyboard.press('o');
    await undo(steps);
    assert.equal((await compare(page))?.tissue, sum?.tissue);
});

test('the threshold changes the endoscope’s picture and its line in the sections', async () => {
    const start = await all(page);
    await page.getByLabel('as a line in the sections').check();
    const lines = await all(page);
    assert.deepEqual(
        kViews.filter((v) => lines[v] !== start[v]),
        ['axial', 'coronal', 'sagittal'],
    );
    const number = page.getByLabel('Threshold, number');
    await number.fill('-150');
    await number.press('Enter');
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.shared!.iso_hu === -150,
    );
    const changed = await all(page);
    assert.deepEqual(
        kViews.filter((v) => changed[v] !== lines[v]),
        [...kViews],
    );
    await picture(page, 'threshold');
    await page.locator('.view.axial').focus();
    await page.keyboard.press('Control+z');
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.shared!.iso_hu === -500,
    );
    await page.getByLabel('as a line in the sections').uncheck();
    assert.deepEqual(await all(page), start);
});

test('walls that leak at a threshold are closed by another, found in the lumen', async () => {
    const isoOf = async (): Promise<number> => (await stateOf(page)).shared!.iso_hu;
    const button = page.getByRole('button', { name: 'Close walls' });
    const message = page.locator('.message');
    await button.click();
    await message.filter({ hasText: /no leak at this threshold.* ml$/ }).waitFor();
    const number = page.getByLabel('Threshold, number');
    await number.fill('150'); // of mucosa and muscle
    await number.press('Enter');
    await untilState(page, ({ shared }) => shared?.iso_hu === 150, 5);
    await button.click();
    await untilState(page, ({ shared }) => shared!.iso_hu < 100, 5);
    const closed = await isoOf();
    assert.ok(closed > -1000, `${closed} HU`);
    await message.filter({ hasText: `walls closed at ${closed.toFixed(0)} HU` }).waitFor();
    await button.click();
    await message.filter({ hasText: 'no leak at this threshold' }).waitFor();
    await page.locator('.view.axial').focus();
    await page.keyboard.press('Control+z');
    await page.keyboard.press('Control+z');
    await untilState(page, ({ shared }) => shared?.iso_hu === -500, 5);
});

test('air follows the threshold on request', async () => {
    const shared = async (): Promise<SharedState> => (await stateOf(page)).shared!;
    const { iso_hu: start, materials } = await shared();
    const air = async (): Promise<number> => (await shared()).materials.air_threshold_hu;
    const ask = async (iso_hu: number): Promise<void> => {
        await page.evaluate((iso) => {
            (window as never as { pliant: Session }).pliant.threshold.ask({ iso_hu: iso });
        }, iso_hu);
        await untilState(page, ({ shared: now }) => now!.iso_hu === iso_hu);
        await page.waitForTimeout(800);
    };
    await ask(start - 40);
    assert.equal(await air(), materials.air_threshold_hu);
    await page.locator('summary', { hasText: /^Material$/ }).click();
    const tie = page.getByLabel('air is what the threshold shows as empty');
    await tie.check();
    await untilState(page, ({ shared: now }) => now!.materials.air_threshold_hu === start - 40);
    await ask(start - 90);
    assert.equal(await air(), start - 90);
    // Each change is a step of undo.
    const { undo } = await shared();
    assert.equal(undo.next, 'materials');
    await page.locator('#undo').click();
    await untilState(page, ({ shared: now }) => now!.materials.air_threshold_hu === start - 40);
    await tie.uncheck();
    await ask(start);
    assert.equal(await air(), start - 40);
});

test('a tip that pushes moves the wall, and the eye goes on', async (t) => {
    if (served.mock) return t.skip('the mock does not always answer in time for a flight');
    const start = await stateOf(page);
    const sum = await compare(page);
    await page.getByLabel('pushes').check();
    await page.locator('.view.endoscope').focus();
    await dragBy(page, await spot(page, 'endoscope', 0.2), [330, 0]);
    await page.keyboard.down('w');
    await page.waitForFunction(
        (n) => (window as never as { pliant: Session }).pliant.store.state.shared!.undo.steps > n,
        start.shared!.undo.steps,
        { timeout: 60_000 },
    );
    await page.waitForTimeout(800);
    await page.keyboard.up('w');
    await page.waitForTimeout(200);
    await idle(page);
    const pushed = await compare(page);
    assert.equal(pushed?.same, true);
    assert.notEqual(pushed?.own, sum?.own);
    await picture(page, 'tip_pushes');
    await page.getByLabel('stops').check();
    await page.locator('.view.endoscope').focus();
    await undo(start.shared!.undo.steps);
    assert.equal((await compare(page))?.own, sum?.own);
    await page.evaluate(
        (camera) => (window as never as { pliant: Session }).pliant.store.set({ view: { camera } }),
        start.view.camera,
    );
});

test('tissue pushed over the eye moves it aside, and lets it back', async () => {
    const start = await stateOf(page);
    const value = (): Promise<number> =>
        page.evaluate(() => {
            const session = (window as never as { pliant: Session }).pliant;
            const { grid } = session.volume!;
            const { eye } = session.store.state.view.camera;
            return session.volume!.sample(
                eye.map((v, a) => (v - grid.origin[a]!) / grid.spacing[a]!) as never,
            );
        });
    // The eye is close to a wall, and the wall is pushed over it.
    const eye = await page.evaluate(async () => {
        const session = (window as never as { pliant: Session }).pliant;
        const { camera } = session.store.state.view;
        const wall = [...camera.eye] as [number, number, number];
        const { grid } = session.volume!;
        const at = (): number =>
            session.volume!.sample(
                wall.map((v, a) => (v - grid.origin[a]!) / grid.spacing[a]!) as never,
            );
        while (at() < -500) wall[0] += 0.1;
        const near: [number, number, number] = [wall[0] - 0.5, wall[1], wall[2]];
        session.endoscope.goTo(near, camera.look, camera.up);
        const point = [wall[0] + 2, wall[1], wall[2]] as const;
        await session.ask({ do: 'push', point, push: [-3, 0, 0], radius: 4 });
        return near;
    });
    await idle(page);
    assert.ok((await value()) < -500, 'the eye is in tissue');
    const aside = (await stateOf(page)).view.camera.eye;
    assert.notDeepEqual(aside, eye, 'nothing was pushed over the eye');
    await undo(start.shared!.undo.steps);
    await idle(page);
    assert.deepEqual((await stateOf(page)).view.camera.eye, eye);
    await page.evaluate(
        (camera) => (window as never as { pliant: Session }).pliant.store.set({ view: { camera } }),
        start.view.camera,
    );
});

test('a second browser joins late, and both agree after pushes by both', async () => {
    const push = (at: Page, x: number): Promise<unknown> =>
        at.evaluate(async (dx) => {
            const session = (window as never as { pliant: Session }).pliant;
            const { camera } = session.store.state.view;
            const point = [camera.eye[0] + dx, camera.eye[1], camera.eye[2]] as const;
            await session.ask({ do: 'push', point, push: [dx / 4, 1, 0], radius: 8 });
        }, x);
    const steps = await undoSteps();
    await push(page, 10);
    const second = await visit(browser, served.link, '&notour&name=Ben');
    assert.equal((await compare(second.page))?.same, true);
    await Promise.all([push(page, -10), push(second.page, 12)]);
    await Promise.all([idle(page), idle(second.page)]);
    const [a, b] = [await compare(page), await compare(second.page)];
    assert.equal(a?.same, true);
    assert.equal(b?.same, true);
    assert.equal(a?.own, b?.own);
    assert.match((await page.locator('#link').textContent()) ?? '', /2 in this session/);
    await picture(second.page, 'second_browser');
    assert.deepEqual(second.errors, []);
    await second.page.context().close();
    await undo(steps);
});

test('a view-only link can look, but not change anything', async () => {
    const viewer = await visit(browser, served.link, '&notour&role=view');
    assert.equal((await stateOf(viewer.page)).link.role, 'view');
    assert.equal(await viewer.page.locator('[data-tool=push]').isDisabled(), true);
    assert.equal(await viewer.page.getByLabel('Threshold, number').isDisabled(), true);
    const sum = await compare(viewer.page);
    await viewer.page.locator('.view.axial').focus();
    await viewer.page.keyboard.press('3');
    await viewer.page.keyboard.press('Enter');
    await viewer.page.keyboard.press('Period');
    await viewer.page.waitForTimeout(300);
    assert.equal((await compare(viewer.page))?.tissue, sum?.tissue);
    assert.equal((await stateOf(viewer.page)).shared!.iso_hu, -500);
    await viewer.page.context().close();
});

test('after a reload the view and the voxels are the same', async () => {
    await cursorToWall();
    const { client } = (await stateOf(page)).link;
    await page.locator('.view.axial').focus();
    await page.keyboard.press('3');
    await page.keyboard.press('Alt+ArrowLeft');
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.shared!.undo.steps > 0,
    );
    await idle(page);
    const sum = await compare(page);
    const {
        view: { camera },
        sections: { window: width },
    } = await stateOf(page);
    await page.reload();
    await page.evaluate(() =>
        (window as never as { pliant: Session }).pliant.store.set({ display: { fine: false } }),
    );
    await loaded(page);
    const again = await compare(page);
    assert.equal(again?.same, true);
    assert.equal(again?.own, sum?.own);
    const state = await stateOf(page);
    assert.equal(state.link.client, client);
    assert.deepEqual(state.view.camera, camera);
    assert.deepEqual([state.sections.window, state.tool.name], [width, 'push']);
    await page.locator('.view.axial').focus();
    await undo(0);
});

test(
    'a lost connection is resumed, with the changes since',
    { skip: !!process.env.PLIANT_SERVER },
    async () => {
        const before = await compare(page);
        served.mock!.breakLines();
        await page.waitForFunction(
            () =>
                (window as never as { pliant: Session }).pliant.store.state.link.status === 'lost',
        );
        served.mock!.scene.carve([0, 0, 0], [4, 0, 0], 5);
        await page.waitForFunction(
            () =>
                (window as never as { pliant: Session }).pliant.store.state.link.status === 'open',
            undefined,
            { timeout: 20_000 },
        );
        await idle(page);
        const after = await compare(page);
        assert.equal(after?.same, true);
        assert.notEqual(after?.own, before?.own);
        served.mock!.scene.reset();
    },
);

test('a lost graphics context comes back with the same pictures', async () => {
    await idle(page);
    const start = await all(page);
    await page.evaluate(() => {
        const { renderer } = (window as never as { pliant: Session }).pliant.stage;
        const lose = renderer.getContext().getExtension('WEBGL_lose_context')!;
        lose.loseContext();
        setTimeout(() => lose.restoreContext(), 400);
    });
    await page.waitForTimeout(200);
    assert.match((await page.locator('.notice').textContent()) ?? '', /graphics context/);
    await page.waitForSelector('.notice', { state: 'hidden' });
    await still(page);
    assert.deepEqual(await all(page), start);
});
