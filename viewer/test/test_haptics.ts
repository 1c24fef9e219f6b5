// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A simulated device pushes the phantom: by the panel, with a second browser as a viewer. And the
// motions of the browser's own devices.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import { voxelFromWorld } from '../src/maths/grid.ts';
import { inTissue } from '../src/maths/rays.ts';
import { add, type Vec3 } from '../src/maths/vec.ts';
import { VolumeData } from '../src/maths/volume.ts';
import type { HapticsNews } from '../src/net/protocol.ts';
import { feltText, plotTop } from '../src/panels/panel_haptics.ts';
import { initialState, type View } from '../src/state/state.ts';
import { startOfTool } from '../src/tools/haptics.ts';
import { capMotion, moved, padMotion } from '../src/tools/pads.ts';
import type { Session } from '../src/tools/session.ts';
import { spotInView } from '../src/views/projection.ts';
import { kGrid, MockScene, tubeCentre } from './mock_scene.ts';
import { compare, picture, stateOf, untilState, visit } from './browser.ts';
import { browser, page, served, useOnePage } from './one_page.ts';

useOnePage({ name: 'Anna', size: 64 });

const until = (on: Page, holds: (news: HapticsNews) => boolean): Promise<void> =>
    untilState(on, ({ device: { news } }) => Boolean(news && holds(news)));

/// Contrast of two colours of the form rgb(r, g, b), as WCAG 2 defines it.
function contrast(a: string, b: string): number {
    const [high, low] = [a, b]
        .map((colour) => {
            const [r, g, b] = colour.match(/[\d.]+/g)!.map((c) => {
                const s = Number(c) / 255;
                return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
            });
            return 0.2126 * r! + 0.7152 * g! + 0.0722 * b! + 0.05;
        })
        .sort((x, y) => y - x);
    return high! / low!;
}

/// Switches drawing on or off: software rendering overloads a slow machine.
const draw = (on: Page, draws: boolean): Promise<void> =>
    on.evaluate((yes) => {
        const { stage } = (window as never as { pliant: Session }).pliant;
        if (yes) delete (stage as Partial<typeof stage>).frame;
        else stage.frame = () => false;
    }, draws);

test('the tool of a device begins beside the middle of the view, if the lumen has room', () => {
    const scene = new MockScene();
    const volume = new VolumeData(kGrid, scene.halves);
    const surface = { iso: -500, rising: true };
    const { view } = initialState();
    const from = (eye: Vec3): View => ({
        ...view,
        camera: { eye, look: [0, 0, -1], up: [0, 1, 0] },
    });
    const wide = from(tubeCentre(10));
    const radius = 1.5;
    const start = startOfTool(volume, wide, radius, surface);
    const spots = [-1, 1].map((side) =>
        spotInView(wide, add(start, [side * radius, side * radius, 0]), {
            width: 300,
            height: 300,
        }),
    );
    // Right of the picture's middle and below it; the lumen has no more room.
    for (const spot of spots) assert.ok(spot![0] > 185 && spot![1] > 185, `${spot}`);
    assert.ok(!inTissue(volume.sample(voxelFromWorld(kGrid, start)), surface));
    const eye = add(tubeCentre(10), [0, 3, 0]);
    const near: View = { ...view, camera: { eye, look: [0, 1, 0], up: [0, 0, 1] } };
    const straight = startOfTool(volume, near, radius, surface);
    assert.ok(Math.abs(straight[0] - eye[0]) < 0.5, `${straight}: before a wall`);
});

test('a device pushes the tissue in all browsers until it is stopped', async (t) => {
    const { features } = (await stateOf(page)).link;
    if (!features.includes('haptics')) return t.skip('the mock has none');
    const title = page.locator('summary', { hasText: /^Device$/ });
    const panel = page.locator('details', { has: title });
    await title.click();
    await panel.getByLabel('Device', { exact: true }).selectOption('virtual:tap');
    // Close in front of the carina, so that the tool's motion of 8 mm ends in it.
    await page.evaluate(() => {
        const session = (window as never as { pliant: Session }).pliant;
        session.endoscope.goTo([0.3, -2.2, 22], [-0.019, 0.045, -0.999]);
    });
    await page.evaluate(() => {
        (window as never as { pliant: Session }).pliant.endoscope.fly([-1.1, 2.7, -60]);
    });
    await draw(page, false);
    const other = await visit(browser, served.link, '&notour&role=view&name=Ben');
    const before = (await compare(page))!;
    await draw(other.page, false);

    await panel.getByRole('button', { name: 'Start' }).click();
    await until(page, (news) => news.contact! && news.depth_mm! > 1);
    await until(other.page, (news) => news.contact! && news.largest_n! > 0.01);
    assert.notEqual((await compare(page))!.tissue, before.tissue);
    await other.page.waitForFunction(() =>
        (window as never as { pliant: Session }).pliant.store.state.hands.others.some(
            (t) => t.touches,
        ),
    );
    assert.match((await panel.locator('.felt').textContent())!, /^\d\.\d\d N now, 0\.\d/);
    const lit = (): Promise<number> =>
        page.evaluate(() => {
            const canvas = document.querySelector<HTMLCanvasElement>('canvas.force')!;
            const { data } = canvas
                .getContext('2d')!
                .getImageData(0, 0, canvas.width, canvas.height);
            let sum = 0;
            for (let i = 3; i < data.length; i += 4) sum += data[i]! * (i % 977);
            return sum;
        });
    const plot = await lit();
    for (let n = 0; n < 100 && (await lit()) === plot; ++n) await page.waitForTimeout(50);
    assert.notEqual(await lit(), plot);
    // The curve and its ground in the dark theme.
    await page.evaluate(() => {
        document.documentElement.dataset.theme = 'dark';
    });
    const colours = await page.locator('canvas.force').evaluate((plot) => {
        const { accentColor, color } = getComputedStyle(plot);
        const ground = getComputedStyle(plot.closest('.panels')!).backgroundColor;
        return { curve: accentColor, text: color, ground };
    });
    for (const over of [colours.curve, colours.text])
        assert.ok(contrast(over, colours.ground) >= 4.5, JSON.stringify(colours));
    await page.evaluate(() => {
        delete document.documentElement.dataset.theme;
    });
    await draw(page, true);
    await panel.locator('dl.servo').scrollIntoViewIfNeeded();
    await picture(page, 'haptics');
    await draw(page, false);

    assert.equal(await other.page.locator('button.stop').isDisabled(), true);
    await page.keyboard.press('h');
    await until(page, (news) => news.stopped! && Math.hypot(...news.force_n!) === 0);
    await until(other.page, (news) => news.stopped!);
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.shared!.settled,
        undefined,
        { timeout: 30_000 },
    );
    const after = (await compare(page))!;
    const seen = (await compare(other.page))!;
    assert.ok(after.same && seen.same);
    assert.equal(seen.own, after.own);
    // The tissue has relaxed.
    assert.equal(after.tissue, before.tissue);

    await panel.getByRole('button', { name: 'Go on' }).click();
    await until(page, (news) => !news.stopped);
    await panel.getByRole('button', { name: 'End' }).click();
    await other.page.waitForFunction(
        () => !(window as never as { pliant: Session }).pliant.store.state.device.news,
    );
    assert.deepEqual(other.errors, []);
    await other.page.context().close();
});

test('sticks and caps give speeds, and positions stay in the workspace', () => {
    const pad = (...axes: number[]): Parameters<typeof padMotion>[0] => ({ axes, buttons: [] });
    assert.deepEqual(padMotion(pad(0.1, -0.1, 0, 0.05)).map(Math.abs), [0, 0, 0]);
    const [right, up, back] = padMotion(pad(1, -1, 0, -1));
    assert.ok(right === 40 && up === 40 && back === -40);
    const report = new DataView(new ArrayBuffer(6));
    report.setInt16(0, 350, true);
    report.setInt16(2, -350, true);
    report.setInt16(4, 350, true);
    assert.deepEqual(capMotion(report), [40, -40, -40]);
    assert.deepEqual(moved([0, 0, 0], [40, 0, -40], 0.5), [20, 0, -20]);
    assert.deepEqual(moved([99, 0, 0], [40, 0, 0], 1), [100, 0, 0]);
});

test('forces are described in words', () => {
    assert.equal(feltText(null, []), 'no device');
    const news = { t: 'haptics', on: true, force_n: [0, 0.3, 0.4], contact: true } as HapticsNews;
    const felt = [{ at: 0, newtons: 0.75 }];
    assert.equal(
        feltText({ ...news, depth_mm: 2.04 }, felt),
        '0.50 N now, 0.75 N at most in 10 s; 2.0 mm deep',
    );
    assert.match(feltText({ ...news, stopped: true }, felt), /stopped$/);
    assert.match(
        feltText({ ...news, depth_mm: 0.26, holds: 'catheter' }, felt),
        /holds the catheter, 0\.3 mm ahead of it$/,
    );
    assert.deepEqual([0, 0.1, 0.11, 7, 12.5].map(plotTop), [0.1, 0.1, 0.2, 10, 13]);
});
