// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// An organ as a newcomer meets it: its first view, the panels about it, tools of a suitable size,
// and the tools that it doesn't take.

import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test, type TestContext } from 'node:test';
import type { Locator } from 'playwright-core';
import type { Vec3 } from '../src/maths/vec.ts';
import type { State } from '../src/state/state.ts';
import { spotInView } from '../src/views/projection.ts';
import { picture, pixels, rectOf, spot, stateOf, untilState } from './browser.ts';
import { page, served, useOnePage } from './one_page.ts';
import { plateStl } from './plate.ts';

const folder = mkdtempSync(join(tmpdir(), 'pliant-organ-'));
const file = join(folder, 'plate.stl');
writeFileSync(file, plateStl());
after(() => rmSync(folder, { recursive: true }));
useOnePage({ file });

const organTest = (name: string, run: (t: TestContext) => Promise<void>): void =>
    void test(name, async (t) => (served.mock ? t.skip('the mock has no bodies') : run(t)));

const panel = (title: string): Locator =>
    page.locator('aside details', {
        has: page.locator('summary', { hasText: new RegExp(`^${title}$`) }),
    });

organTest('the panel of the tissue is open, and lists the bodies with their moduli', async () => {
    const { tissue } = (await stateOf(page)).shared!;
    assert.equal(await panel('Tissue').getAttribute('open'), '');
    assert.equal(await panel('Tissue').getByLabel('organs').isChecked(), true);
    const lines = await panel('Tissue').locator('.organs li').allTextContents();
    const count = (tissue as unknown as { tetrahedra: number }).tetrahedra;
    assert.equal(lines[0], `plate: ${count} tetrahedra, neo-Hookean, 15 kPa, ν 0.45`);
    assert.match(lines[1]!, new RegExp(`^${tissue!.particles} nodes, [1-9]\\d* of them held; `));
    assert.equal(lines[2], 'not moved yet');
    assert.equal(await panel('Material').isHidden(), true);
    await picture(page, 'organ_panel');
});

organTest('an organ is seen whole from all sides at first', async () => {
    const caption = page.locator('.view.endoscope .caption');
    assert.equal(await caption.textContent(), 'from outside');
    const { view } = await stateOf(page);
    const box = await rectOf(page, 'endoscope');
    for (let corner = 0; corner < 8; ++corner) {
        const at = [30, 6, 30].map((x, a) => ((corner >> a) & 1 ? x : -x)) as never as Vec3;
        const [x, y] = spotInView(view, at, box)!;
        assert.ok(x > 0 && x < box.width && y > 0 && y < box.height, `${at} is at ${x}, ${y}`);
    }
    const front = await pixels(page, 'endoscope');
    await page.keyboard.press('Control+Numpad1');
    const back = await pixels(page, 'endoscope');
    // A plate looks the same from both sides.
    assert.ok(front.lit > 0.1, `${front.lit} of the picture from the front`);
    assert.ok(Math.abs(back.lit - front.lit) < 0.05, `${back.lit} from the back`);
    await picture(page, 'organ_behind');
    await page.keyboard.press('Numpad1');
});

organTest('a tool is larger than the cells at first; a smaller one is commented on', async () => {
    const { tool, shared } = await stateOf(page);
    const edge = shared!.tissue!.edge_mm!;
    assert.ok(tool.radius > edge, `${tool.radius} mm for edges of ${edge} mm`);
    const note = panel('Tool').getByText('smaller than the tetrahedra');
    assert.equal(await note.isHidden(), true);
    const size = panel('Tool').getByLabel('Size').last();
    await size.fill('0.5');
    await size.press('Enter');
    await untilState(page, (state) => state.tool.radius === 0.5);
    assert.equal(await note.isVisible(), true);
    await size.fill(String(tool.radius));
    await size.press('Enter');
    await untilState(page, (state) => state.tool.radius > 1);
});

organTest('a tool that an organ does not take can not be chosen', async () => {
    const tools = page.locator('.tools');
    const { takes } = (await stateOf(page)).shared!.tissue!;
    assert.ok(takes!.includes('push') && !takes!.includes('carve'));
    assert.equal(await tools.getByText('Carve').isDisabled(), true);
    assert.equal(await tools.getByText('Grab').isDisabled(), false);
    await page.keyboard.press('Digit6');
    assert.equal((await stateOf(page)).tool.name, 'look');
    assert.match((await page.locator('.message').textContent())!, /does not take/);
});

organTest('a push by the mouse is felt, and taken back', async () => {
    await page.keyboard.press('Digit3');
    const [x, y] = await spot(page, 'endoscope');
    await page.mouse.move(x, y);
    await page.mouse.down();
    // The probe goes into the organ while the button is held.
    await untilState(page, ({ hands, shared }) => hands.force_n > 0 && shared!.undo.steps === 1);
    assert.match(
        (await page.locator('.view.endoscope').textContent())!,
        /\d\.\d\d N/,
        'the force is shown',
    );
    await picture(page, 'organ_pushed');
    await page.mouse.up();
    await untilState(page, ({ hands }) => hands.force_n === 0);
    await page.keyboard.press('Control+z');
    await untilState(page, ({ shared }) => shared!.undo.steps === 0 && shared!.settled);
    const pace = panel('Tissue').locator('.organs li').last();
    assert.match(
        (await pace.textContent())!,
        /^(pace of the last motion: (slow, 1\/\d+ of|[\d.]+ ×) real time|not moved yet)$/,
    );
    await page.keyboard.press('Digit1');
});

organTest('a device from outside taps the organ in the middle, and is felt', async () => {
    await panel('Device').locator('summary').click();
    await panel('Device').getByLabel('Device', { exact: true }).selectOption('virtual:tap');
    await panel('Device').getByRole('button', { name: 'Start' }).click();
    const force = ({ device }: State): number => device.news?.largest_n ?? 0;
    await untilState(page, (state) => state.device.news?.contact === true && force(state) > 0.01);
    const { device, tool } = await stateOf(page);
    const place = device.news!.place_mm!;
    // In front of the plate, whose face is at y = -6.
    assert.ok(Math.hypot(place[0], place[2]) < 2 && place[1] < 0, `${place}`);
    const own = (await stateOf(page)).hands.others.find((t) => t.client === device.news!.tool);
    assert.ok(Math.abs(own!.radius - tool.radius) < 1e-3);
    await untilState(page, (state) => state.device.news?.contact === false);
    await untilState(page, (state) => force(state) === 0);
    await panel('Device').getByRole('button', { name: 'End' }).click();
    await untilState(page, (state) => state.device.news === null);
    await page.locator('#undo').click();
});

organTest('another model can be chosen, and the organ again', async () => {
    await panel('Tissue').getByLabel('ChainMail').check();
    await untilState(page, ({ shared }) => shared!.tissue!.model === 'chainmail');
    assert.equal(await panel('Material').isVisible(), true);
    assert.equal(await page.locator('.tools').getByText('Carve').isDisabled(), false);
    await page.keyboard.press('Digit6');
    assert.equal((await stateOf(page)).tool.name, 'carve');
    await panel('Tissue').getByLabel('organs').check();
    await untilState(page, ({ shared }) => shared!.tissue!.model === 'own');
    await untilState(page, ({ tool }) => tool.name === 'look');
    assert.equal(await panel('Material').isHidden(), true);
});
