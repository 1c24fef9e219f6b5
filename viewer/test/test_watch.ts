// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A recorded session on the page: its time line, and the tissue at each time, compared by the
// checksums that were taken while it was recorded.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import type { Vec3 } from '../src/maths/vec.ts';
import type { Command } from '../src/net/protocol.ts';
import { ticksOf, timeText } from '../src/panels/timeline.ts';
import { markBeside } from '../src/tools/replay_tool.ts';
import type { Session } from '../src/tools/session.ts';
import {
    compare,
    kFolder,
    launch,
    picture,
    rectOf,
    serve,
    type Served,
    stateOf,
    untilState,
    visit,
} from './browser.ts';

const program = process.env.PLIANT_SERVER;
const folder = mkdtempSync(join(tmpdir(), 'pliant-watch-'));
const session = join(folder, 's.pls');
const commands: Command[] = []; // that are recorded
const sums: string[] = []; // of the tissue: before, and after each command
let browser: Browser;
let served: Served;
let page: Page;
let viewer: Page;
const errors: string[][] = [];

async function open(link: string, settings = {}): Promise<Page> {
    const visited = await visit(browser, link, '&notour', { bypassCSP: true, ...settings });
    errors.push(visited.errors);
    return visited.page;
}

async function sumOf(at: Page): Promise<string> {
    const sum = await compare(at);
    assert.ok(sum?.same, 'the page has the voxels of the server');
    return sum.tissue;
}

before(async () => {
    browser = await launch();
    const scan = join(folder, 'airway.nrrd');
    if (program) execFileSync(program, ['phantom', 'airway', '--size', '32', '--out', scan]);
    const live = await serve(scan, '--session', session);
    const hand = await open(live.link);
    sums.push(await sumOf(hand));
    const { size, spacing_mm, origin_mm } = (await stateOf(hand)).scan.volume!;
    const point = origin_mm.map(
        (x, a) => x + 0.5 * spacing_mm[a]! * (size[a]! - 1),
    ) as never as Vec3;
    const motions: Vec3[] = [
        [0, 0, 6],
        [0, 4, 0],
        [3, 0, 2],
    ];
    const pushes = motions.map((push) => ({ point, push, radius: 8 }));
    pushes.forEach((by, n) => commands.push({ do: 'push', ...by, stroke: n + 1 }));
    if (program) commands.push({ do: 'undo' }, { do: 'iso', iso_hu: -400 });
    for (const command of commands) {
        await hand.waitForTimeout(400);
        await hand.evaluate(
            (c) => (window as unknown as { pliant: Session }).pliant.connection.ask(c),
            command,
        );
        sums.push(await sumOf(hand));
    }
    const moved = sums.slice(0, motions.length + 1);
    assert.equal(new Set(moved).size, moved.length, 'each push moves tissue');
    await hand.waitForTimeout(400);
    await hand.context().close();
    if (live.mock) {
        const times = pushes.map((by, n) => ({ at_ms: 500 * (n + 1), ...by }));
        live.mock.watch(times, 2000);
        served = live;
    } else {
        await live.stop();
        served = await serve('--replay', session);
    }
    page = await open(served.link);
    viewer = await open(`${served.link}&role=view`);
    await untilState(page, ({ replay }) => replay.length > 0, 10);
});
after(async () => {
    await browser.close();
    await served.stop();
    rmSync(folder, { recursive: true });
    assert.deepEqual(errors.flat(), []);
});

const marks = [800, 1500, 1500, 4000].map((at_ms) => ({ at_ms, client: 1, do: 'let_go' }));

test('times are m:ss, and marks that are close together share a tick', () => {
    assert.equal(timeText(61_999), '1:01');
    assert.equal(timeText(0), '0:00');
    const ticks = ticksOf(marks, 5000, (client) => `visitor ${client}`);
    assert.deepEqual(
        ticks.map(({ at }) => at),
        [800, 1500, 4000],
    );
    assert.equal(ticks[0]!.title, '0:00 let go, visitor 1');
    assert.equal(ticks[1]!.title, '0:01 let go, visitor 1, and 1 more');
});

test('the marks beside a time are not those of the time itself', () => {
    assert.equal(markBeside(marks, 0, 1, 0), 800);
    assert.equal(markBeside(marks, 1500, 1, 0), 4000);
    assert.equal(markBeside(marks, 1500, -1, 0), 800);
    assert.equal(markBeside(marks, 1600, -1, 500), 800);
    assert.equal(markBeside(marks, 4000, 1, 0), undefined);
    assert.equal(markBeside(marks, 800, -1, 0), undefined);
});

/// Waits for a time of the session, with its scene.
const untilAt = (at: Page, holds: (ms: number, length: number) => boolean): Promise<unknown> =>
    (async () => {
        for (const end = Date.now() + 20_000; ; await at.waitForTimeout(50)) {
            const { replay } = await stateOf(at);
            if (!replay.seeking && !replay.playing && holds(replay.at, replay.length)) return;
            assert.ok(Date.now() < end, JSON.stringify(replay));
        }
    })();

test('the keys , and . go from command to command, with the recorded tissue', async () => {
    const { replay } = await stateOf(page);
    assert.deepEqual(
        replay.marks.map((mark) => mark.do),
        commands.map((command) => command.do),
    );
    assert.equal(await page.locator('.ticks i').count(), commands.length);
    assert.match((await page.locator('.ticks i').first().getAttribute('title'))!, /push, visitor/);
    // At a mark its own command is still to come.
    for (const [n, mark] of replay.marks.entries()) {
        await page.keyboard.press('.');
        await untilAt(page, (ms) => ms === mark.at_ms);
        assert.equal(await sumOf(page), sums[n], `before command ${n}`);
    }
    await page.keyboard.press('.');
    await untilAt(page, (ms, length) => ms === length);
    assert.equal(await sumOf(page), sums[commands.length]);
    assert.equal(await sumOf(viewer), sums[commands.length]);
    await page.keyboard.press(',');
    await untilAt(page, (ms) => ms === replay.marks[commands.length - 1]!.at_ms);
    await page.getByRole('button', { name: 'Previous command' }).click();
    await untilAt(page, (ms) => ms === replay.marks[commands.length - 2]!.at_ms);
    assert.equal(await sumOf(page), sums[commands.length - 2], 'backwards');
    // From the request on, until the scene is that of the time.
    const seeks = await page.evaluate(() => {
        const { pliant } = window as unknown as { pliant: Session };
        pliant.replay.jump(0);
        return pliant.store.state.replay.seeking;
    });
    assert.ok(seeks);
    await untilAt(page, (ms) => ms === 0);
    assert.equal(await sumOf(page), sums[0], 'at the start');
});

test('Space plays and pauses, at a chosen speed, up to the end', async () => {
    const slider = page.getByLabel('Time of the session');
    await slider.fill('0');
    await untilAt(page, (ms) => ms === 0);
    assert.equal(await sumOf(page), sums[0]);
    await page.locator('.timeline select').selectOption('0.25');
    await untilState(page, ({ replay }) => replay.speed === 0.25, 5);
    await page.locator('.view.axial').focus();
    await page.keyboard.press('Space');
    await untilState(page, ({ replay }) => replay.playing && replay.at > 0, 5);
    assert.equal(await page.locator('.timeline .play').getAttribute('aria-label'), 'Pause');
    await slider.focus();
    await page.keyboard.press('Space');
    await untilState(page, ({ replay }) => !replay.playing, 5);
    const { at, length } = (await stateOf(page)).replay;
    assert.ok(at < length);
    assert.equal(
        await slider.getAttribute('aria-valuetext'),
        `${timeText(at)} of ${timeText(length)}`,
    );
    await page.locator('.timeline select').selectOption('16');
    await page.getByRole('button', { name: 'Play' }).click();
    await untilAt(page, (ms, whole) => ms === whole);
    assert.equal(await sumOf(page), sums[commands.length]);
});

test('tools that would change the scene are disabled, and say why', async () => {
    for (const tool of ['push', 'grab', 'cut', 'carve']) {
        const button = page.locator(`[data-tool=${tool}]`);
        assert.ok(await button.isDisabled(), tool);
        assert.match((await button.getAttribute('title'))!, /recorded session/);
    }
    assert.ok(await page.locator('[data-tool=measure]').isEnabled());
    assert.ok(await page.getByLabel('Threshold, number').first().isDisabled());
    assert.ok(await page.locator('#open').isDisabled());
    assert.ok(await page.locator('#undo').isDisabled());
    await page.locator('.view.axial').focus();
    await page.keyboard.press('3');
    assert.equal((await stateOf(page)).tool.name, 'look');
    assert.match(await page.locator('.message').innerText(), /recorded session/);
    const status = await page.locator('#link').innerText();
    assert.equal(status, 'watching a recording, 2 in this session');
});

test('the own window can be changed and undone', async () => {
    const { window } = (await stateOf(page)).sections;
    await page.getByLabel('Window, number').fill('900');
    await page.keyboard.press('Enter');
    await untilState(page, ({ sections }) => sections.window === 900, 5);
    assert.notEqual((await stateOf(viewer)).sections.window, 900);
    await page.locator('#undo').click();
    await untilState(page, ({ sections }) => sections.window !== 900, 5);
    assert.equal((await stateOf(page)).sections.window, window);
});

test('viewers see the time line without control', async () => {
    assert.ok(await viewer.locator('.timeline').isVisible());
    for (const name of ['Play', 'Previous command', 'Next command'])
        assert.ok(await viewer.getByRole('button', { name }).isDisabled(), name);
    assert.ok(await viewer.getByLabel('Time of the session').isDisabled());
    await viewer.keyboard.press('Space');
    await viewer.waitForTimeout(300);
    assert.ok(!(await stateOf(page)).replay.playing);
    const { at } = (await stateOf(page)).replay;
    assert.equal((await stateOf(viewer)).replay.at, at);
});

for (const [width, height, theme] of [
    [360, 740, 'light'],
    [740, 360, 'dark'],
    [1280, 720, 'dark'],
    [2560, 1440, 'light'],
] as const)
    test(`the time line fits ${width}×${height}, and axe finds nothing`, async () => {
        const small = width < 800;
        const touch = small ? { hasTouch: true, isMobile: true } : {};
        const at = await open(served.link, { viewport: { width, height }, ...touch });
        await at.evaluate((wanted) => {
            const { pliant } = window as unknown as { pliant: Session };
            pliant.store.set({ display: { theme: wanted } });
        }, theme);
        const line = (await at.locator('.timeline').boundingBox())!;
        const footer = (await at.locator('footer').boundingBox())!;
        const view = await rectOf(at, 'sagittal');
        assert.ok(line.x >= 0 && line.x + line.width <= width);
        assert.ok(line.y >= view.y + view.height - 1 && line.y + line.height <= footer.y + 1);
        for (const part of await at.locator('.timeline :is(button, input, select)').all()) {
            const box = (await part.boundingBox())!;
            assert.ok(box.x >= 0 && box.x + box.width <= width, await part.innerText());
        }
        const track = (await at.locator('.track').boundingBox())!;
        assert.ok(track.width >= 100, `${track.width}`);
        await at.evaluate(readFileSync(join(kFolder, 'node_modules/axe-core/axe.min.js'), 'utf8'));
        const found = await at.evaluate(async () => {
            const { axe } = window as never as {
                axe: { run(): Promise<{ violations: { id: string; nodes: unknown[] }[] }> };
            };
            const { violations } = await axe.run();
            return violations.map(({ id, nodes }) => `${id}: ${JSON.stringify(nodes[0])}`);
        });
        assert.deepEqual(found, []);
        await picture(at, `watch_${width}x${height}`);
        await at.context().close();
    });
