// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Overlays of displacement and volume change, with the legend and the value under the pointer; the
// user's own presets.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import type { Session } from '../src/tools/session.ts';
import { loaded, picture, pixels, spot, stateOf, untilUndo, visit } from './browser.ts';
import { browser, page, served, useOnePage } from './one_page.ts';

useOnePage();

/// Pushes the wall beside the tip, and waits for the voxels.
async function push(visited: Page, by: [number, number, number]): Promise<void> {
    await visited.evaluate(async (motion) => {
        const session = (window as never as { pliant: Session }).pliant;
        const {
            scan: { volume },
            view: { camera },
        } = session.store.state;
        const point = volume!.landmarks[0]?.point_mm ?? camera.eye;
        session.store.set({ sections: { cursor: point } });
        await session.ask({ do: 'push', point, push: motion, radius: 8 });
        // Its answer comes after all boxes.
        await session.compare();
    }, by);
}

const untilOverlay = (visited: Page, kind: string): Promise<unknown> =>
    visited.waitForFunction(
        (wanted) => {
            const { stage, store } = (window as never as { pliant: Session }).pliant;
            return stage.overlay?.kind === wanted && store.state.scan.extreme > 0;
        },
        kind,
        { timeout: 20_000 },
    );

/// Value at the crosshair from the status bar.
const told = async (): Promise<string> =>
    (await page.locator('#pointer').textContent({ timeout: 5000 })) ?? '';

test('the key M shows displacement, then volume change, then neither', async () => {
    await page.mouse.move(640, 3);
    await page.evaluate(() =>
        (window as never as { pliant: Session }).pliant.store.set({ look: { fieldStop: 'full' } }),
    );
    await push(page, [0, 0, 5]);
    await page.locator('.view.axial').focus();
    const legend = page.locator('.legend');
    assert.ok(!(await legend.isVisible()));
    const plain = {
        axial: await pixels(page, 'axial'),
        coronal: await pixels(page, 'coronal'),
        sagittal: await pixels(page, 'sagittal'),
        endoscope: await pixels(page, 'endoscope'),
    };
    await page.keyboard.press('m');
    await untilOverlay(page, 'displacement');
    assert.ok(await legend.isVisible());
    assert.match((await legend.getAttribute('aria-label'))!, /Displacement \[mm\], from 0 to \d/);
    for (const view of ['axial', 'coronal', 'sagittal', 'endoscope'] as const)
        assert.notEqual((await pixels(page, view)).hash, plain[view].hash, view);
    const { extreme: overlayExtreme } = (await stateOf(page)).scan;
    // The mock follows the whole push, tissue a part of it.
    assert.ok(overlayExtreme > (served.mock ? 4 : 1) && overlayExtreme < 8, `${overlayExtreme}`);
    const moved = Number(/moved ([\d.]+) mm/.exec(await told())![1]);
    assert.ok(moved > 0.3 && moved <= overlayExtreme + 0.01, `${moved} mm`);
    await picture(page, 'overlay_displacement');

    await page.keyboard.press('m');
    await untilOverlay(page, 'jacobian');
    assert.match((await legend.getAttribute('aria-label'))!, /Volume change \[×\], from ×/);
    assert.match(await told(), /volume × -?\d+\.\d{3}/);
    await picture(page, 'overlay_jacobian');

    await page.keyboard.press('m');
    await page.waitForFunction(
        () => !(window as never as { pliant: Session }).pliant.stage.overlay,
    );
    assert.ok(!(await legend.isVisible()));
    assert.doesNotMatch(await told(), /moved|volume/);
    for (const view of ['axial', 'coronal', 'sagittal', 'endoscope'] as const)
        assert.equal((await pixels(page, view)).hash, plain[view].hash, view);
});

test('an overlay follows pushes and undo, and shows the value of the mirror', async () => {
    await page.keyboard.press('m');
    await untilOverlay(page, 'displacement');
    const before = (await stateOf(page)).scan.overlay;
    await push(page, [0, 0, -2]);
    await page.waitForFunction(
        (old) => (window as never as { pliant: Session }).pliant.store.state.scan.overlay > old,
        before,
    );
    // Value under the pointer in a section.
    await page.mouse.move(...(await spot(page, 'coronal', 0.5, 0.45)));
    const [shown, held] = await page.evaluate(async () => {
        await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
        const session = (window as never as { pliant: Session }).pliant;
        const text = document.querySelector('#pointer')!.textContent!;
        const [i, j, k] = /ijk (-?\d+), (-?\d+), (-?\d+)/.exec(text)!.slice(1).map(Number);
        const { size } = session.store.state.scan.volume!;
        const at = i! + size[0]! * (j! + size[1]! * k!);
        const half = session.stage.overlay!.halves[at]!;
        const exponent = (half >> 10) & 31;
        const value = exponent
            ? (1 + (half & 1023) / 1024) * 2 ** (exponent - 15)
            : (half & 1023) * 2 ** -24;
        return [/moved ([\d.]+)/.exec(text)![1]!, value.toFixed(2)];
    });
    assert.equal(shown, held);
    await page.mouse.move(640, 3);
    await page.locator('.view.axial').focus();
    await page.keyboard.press('Control+z');
    await untilUndo(page, 1);
    await page.keyboard.press('Control+z');
    await untilUndo(page, 0);
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.scan.extreme === 0,
    );
    await page.keyboard.press('Control+Shift+z');
    await untilUndo(page, 1);
    await untilOverlay(page, 'displacement');
    if (served.mock) assert.ok(served.mock.overlaysSeen > 0);
});

test('opacity and range are set in the panel, and shown by the legend', async () => {
    await page.locator('summary', { hasText: 'Overlay' }).click();
    const strong = await pixels(page, 'coronal');
    await page.getByLabel('Opacity, number').fill('0.2');
    await page.keyboard.press('Enter');
    assert.notEqual((await pixels(page, 'coronal')).hash, strong.hash);
    const legend = page.locator('.legend');
    const most = page.getByLabel('Colours up to, number');
    assert.ok(!(await most.isVisible()));
    await page.getByLabel('range follows the values').uncheck();
    await most.fill('2.5');
    await page.keyboard.press('Enter');
    assert.match((await legend.getAttribute('aria-label'))!, /from 0 to 2.5$/);
    await page.getByLabel('Opacity, number').fill('0.65');
    await page.keyboard.press('Enter');
    await page.locator('summary', { hasText: 'Overlay' }).scrollIntoViewIfNeeded();
    await picture(page, 'overlay_panel');
    await page.getByLabel('range follows the values').check();
    assert.ok(!(await most.isVisible()));
});

test('the legend is readable in light and in dark', async () => {
    for (const theme of ['light', 'dark'] as const) {
        await page.evaluate(
            (wanted) =>
                (window as never as { pliant: Session }).pliant.store.set({
                    display: { theme: wanted },
                }),
            theme,
        );
        const contrast = await page.locator('.legend').evaluate((e) => {
            const lightness = (colour: string): number => {
                const [r, g, b] = colour.match(/[\d.]+/g)!.map((x) => (Number(x) / 255) ** 2.2);
                return 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
            };
            const style = getComputedStyle(e);
            const [a, b] = [lightness(style.color), lightness(style.backgroundColor)];
            return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
        });
        assert.ok(contrast > 7, `${theme}: ${contrast}`);
        await picture(page, `overlay_${theme}`);
    }
    await page.evaluate(() =>
        (window as never as { pliant: Session }).pliant.store.set({ display: { theme: 'system' } }),
    );
});

test('a later client that only views sees the same values', async () => {
    const second = await visit(browser, served.link, '&notour&role=view');
    await second.page.locator('.view.axial').focus();
    await second.page.keyboard.press('m');
    await untilOverlay(second.page, 'displacement');
    const of = (visited: Page): Promise<{ hash: number; moved: number }> =>
        visited.evaluate(async () => {
            const session = (window as never as { pliant: Session }).pliant;
            await session.compare();
            let hash = 2166136261;
            let moved = 0;
            for (const half of session.stage.overlay!.halves) {
                hash = Math.imul(hash ^ half, 16777619);
                if (half > 0) ++moved;
            }
            return { hash, moved };
        });
    const own = await of(page);
    assert.ok(own.moved > 100);
    assert.deepEqual(await of(second.page), own);
    assert.deepEqual(second.errors, []);
    await second.page.context().close();
});

test('the overlay is shown again after a reload and after a lost connection', async () => {
    const before = await stateOf(page);
    await page.reload();
    await loaded(page);
    await untilOverlay(page, 'displacement');
    assert.equal((await stateOf(page)).scan.extreme, before.scan.extreme);
    if (!served.mock) return;
    served.mock.breakLines();
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.link.status !== 'open',
    );
    await loaded(page);
    await untilOverlay(page, 'displacement');
    assert.equal((await stateOf(page)).scan.extreme, before.scan.extreme);
});

test('own presets of window and threshold are named, kept, used and deleted', async () => {
    await page.getByLabel('Window, number').fill('777');
    await page.keyboard.press('Enter');
    const name = page.getByLabel('Presets of window and level: name of an own preset');
    const save = page.getByLabel('Presets of window and level: save as an own preset');
    assert.ok(await save.isDisabled());
    await name.fill('Nodules');
    await save.click();
    const list = page.getByLabel('Presets of window and level', { exact: true });
    await list.selectOption({ label: 'Bone' });
    assert.equal((await stateOf(page)).sections.window, 1000);
    await list.selectOption({ label: 'Nodules' });
    assert.equal((await stateOf(page)).sections.window, 777);

    const iso = page.getByLabel('Presets of the threshold', { exact: true });
    await page.getByLabel('Threshold, number').fill('-333');
    await page.keyboard.press('Enter');
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.shared!.iso_hu === -333,
    );
    await page.getByLabel('Presets of the threshold: name of an own preset').fill('Mine');
    await page.keyboard.press('Enter');
    await iso.selectOption({ label: 'Bone' });
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.shared!.iso_hu === 250,
    );
    await picture(page, 'own_presets');
    const overflow = await page
        .locator('.panels')
        .evaluate((panel) => panel.scrollWidth - panel.clientWidth);
    assert.equal(overflow, 0, 'controls reach beyond the panel');

    await page.reload();
    await loaded(page);
    await iso.selectOption({ label: 'Mine' });
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.shared!.iso_hu === -333,
    );
    await list.selectOption({ label: 'Nodules' });
    assert.equal((await stateOf(page)).sections.window, 777);
    await page.getByLabel('Presets of window and level: delete the own preset').click();
    assert.equal(await list.locator('option', { hasText: 'Nodules' }).count(), 0);
    await page.reload();
    await loaded(page);
    assert.equal(await list.locator('option', { hasText: 'Nodules' }).count(), 0);
    assert.equal(await iso.locator('option', { hasText: 'Mine' }).count(), 1);
});
