// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Springs in the page: chosen around the crosshair, pushed, with another depth, and left.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Session } from '../src/tools/session.ts';
import { springsText } from '../src/panels/panel_springs.ts';
import { compare, picture, stateOf } from './browser.ts';
import { page, useOnePage } from './one_page.ts';

useOnePage({ name: 'Anna' });

type Command = Parameters<Session['connection']['ask']>[0];
const ask = (command: Command): Promise<unknown> =>
    page.evaluate(
        (c) => (window as never as { pliant: Session }).pliant.connection.ask(c),
        command,
    );
const model = async (): Promise<string> => (await stateOf(page)).shared!.tissue!.model;

test('a line that limits the depth is shown beside it', () => {
    const state = {
        model: 'springs',
        nodes: [20, 20, 20],
        active_nodes: 635,
        depth: 7,
        update_hz: 990,
    } as const;
    const text = '20 × 20 × 20 nodes, 635 within 7 layers';
    assert.equal(springsText(state), `${text}, 990 updates/s`);
    assert.equal(
        springsText({ ...state, line_mb_s: 3.9 }),
        `${text} (line takes 3.9 MB/s), 990 updates/s`,
    );
});

test('springs are chosen, pushed at the displayed rate, and left', async (t) => {
    if (!(await stateOf(page)).link.features.includes('tissue')) return t.skip('the mock has none');
    const title = page.locator('summary', { hasText: /^Tissue$/ });
    const panel = page.locator('details', { has: title });
    await panel.locator('summary').click();
    const before = (await compare(page))!;
    await panel.getByLabel("Young's modulus, number").fill('6');
    await panel.getByText('springs', { exact: true }).click();
    await page.waitForFunction(
        () =>
            (window as never as { pliant: Session }).pliant.store.state.shared!.tissue?.model ===
            'springs',
    );
    const chosen = (await stateOf(page)).shared!.tissue!;
    assert.equal(chosen.young_modulus_pa, 6000);
    assert.equal(chosen.poisson_ratio, 0.25);
    const { cursor } = (await stateOf(page)).sections;
    const answer = (await ask({
        do: 'push',
        point: cursor,
        push: [3, 2, 0],
        radius: 6,
    })) as { t: string; status: string; force_n: number[] };
    assert.equal(answer.t, 'done');
    assert.equal(answer.status, 'applied');
    await page.waitForFunction(
        () => {
            const { shared } = (window as never as { pliant: Session }).pliant.store.state;
            return shared!.settled && shared!.tissue!.active_nodes! > 0;
        },
        undefined,
        { timeout: 60_000 },
    );
    const pushed = (await compare(page))!;
    assert.ok(pushed.same);
    assert.match((await panel.locator('.springs').textContent())!, /nodes, \d+ within 10 layers/);
    await picture(page, 'springs');
    await ask({ do: 'depth', layers: 3 });
    await page.waitForFunction(
        () =>
            (window as never as { pliant: Session }).pliant.store.state.shared!.tissue!.depth === 3,
    );
    const refused = (await ask({ do: 'carve', from: cursor, to: cursor, radius: 3 })) as {
        code: string;
    };
    assert.equal(refused.code, 'other_tissue');
    await panel.getByText('Find depth').click();
    await page.waitForFunction(
        () =>
            (window as never as { pliant: Session }).pliant.store.state.shared!.tissue!.depth! > 3,
    );
    const by = panel.getByLabel('automatic depth');
    await by.check();
    await page.waitForFunction(
        () =>
            (window as never as { pliant: Session }).pliant.store.state.shared!.tissue!
                .depth_by_time,
    );
    await ask({ do: 'depth', layers: 8 });
    await page.waitForFunction(
        () =>
            !(window as never as { pliant: Session }).pliant.store.state.shared!.tissue!
                .depth_by_time,
    );
    // A cut through the held tissue, and back.
    const [x, y, z] = cursor;
    const cut = (await ask({
        do: 'cut',
        line: [
            [x - 30, y - 9, z - 20],
            [x + 30, y - 9, z - 20],
        ],
        depth: [0, 0, 40],
    })) as { t: string; cut_links: number };
    assert.equal(cut.t, 'done');
    assert.ok(cut.cut_links > 10);
    await picture(page, 'springs_cut');
    const opened = (await compare(page))!;
    assert.ok(opened.same);
    await ask({ do: 'undo' });
    assert.ok((await compare(page))!.same);
    await panel.getByText('ChainMail', { exact: true }).click();
    await page.waitForFunction(
        () =>
            (window as never as { pliant: Session }).pliant.store.state.shared!.tissue?.model ===
            'chainmail',
    );
    const left = (await compare(page))!;
    assert.ok(left.same);
    assert.ok(before.same);
    assert.equal(await model(), 'chainmail');
});
