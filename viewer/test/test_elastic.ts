// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The elastic scan in the page: chosen, changed, pushed, and left.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Session } from '../src/tools/session.ts';
import { compare, picture, stateOf } from './browser.ts';
import { page, useOnePage } from './one_page.ts';

useOnePage({ name: 'Anna' });

type Command = Parameters<Session['connection']['ask']>[0];
const ask = (command: Command): Promise<unknown> =>
    page.evaluate(
        (c) => (window as never as { pliant: Session }).pliant.connection.ask(c),
        command,
    );
const tissueIs = (model: string): Promise<unknown> =>
    page.waitForFunction(
        (m) =>
            (window as never as { pliant: Session }).pliant.store.state.shared!.tissue?.model === m,
        model,
    );

test('the elastic scan is chosen, changed, pushed and left', async (t) => {
    if (!(await stateOf(page)).link.features.includes('tissue')) return t.skip('the mock has none');
    const title = page.locator('summary', { hasText: /^Tissue$/ });
    const panel = page.locator('details', { has: title });
    await panel.locator('summary').click();
    await panel.getByText('elastic', { exact: true }).click();
    await tissueIs('elastic');
    const chosen = (await stateOf(page)).shared!.tissue!;
    assert.equal(chosen.poisson_ratio, 0.45);
    assert.equal(chosen.held_above_hu, 300);
    const count = chosen.moduli_kpa!.length;
    assert.ok(count > 3);
    assert.equal(await panel.locator('.moduli circle').count(), count);
    await picture(page, 'elastic');
    // ChainMail's settings are not offered.
    const material = page.locator('details', {
        has: page.locator('summary', { hasText: /^Material$/ }),
    });
    await material.locator('summary').click();
    assert.ok(await material.getByText('for ChainMail').isVisible());
    assert.ok(!(await material.getByText('Softness').isVisible()));

    // A point by the keyboard, one more, Poisson's ratio.
    const point = panel.getByRole('slider', { name: 'Point 3', exact: true });
    await point.press('ArrowUp');
    await page.waitForFunction(
        (before) =>
            (window as never as { pliant: Session }).pliant.store.state.shared!.tissue!
                .moduli_kpa![2]![1] > before,
        chosen.moduli_kpa![2]![1],
    );
    await point.press('+');
    await page.waitForFunction(
        (n) =>
            (window as never as { pliant: Session }).pliant.store.state.shared!.tissue!.moduli_kpa!
                .length === n,
        count + 1,
    );
    await panel.getByLabel("Poisson's ratio of tissue, number").fill('0.4');
    await panel.getByLabel("Poisson's ratio of tissue, number").press('Enter');
    await page.waitForFunction(
        () =>
            (window as never as { pliant: Session }).pliant.store.state.shared!.tissue!
                .poisson_ratio === 0.4,
    );
    assert.equal((await stateOf(page)).shared!.tissue!.moduli_kpa!.length, count + 1);

    const { cursor } = (await stateOf(page)).sections;
    const answer = (await ask({ do: 'push', point: cursor, push: [0.5, 0.2, 0], radius: 6 })) as {
        t: string;
        status: string;
        force_n: number[];
    };
    assert.equal(answer.t, 'done');
    assert.equal(answer.status, 'applied');
    assert.ok(answer.force_n[0]! < 0, 'the tissue pushes back');
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.shared!.settled,
        undefined,
        { timeout: 60_000 },
    );
    assert.ok((await compare(page))!.same);
    await picture(page, 'elastic_pushed');
    const carved = (await ask({ do: 'carve', from: cursor, to: cursor, radius: 6 })) as {
        carved_elements?: number;
    };
    assert.ok(carved.carved_elements! > 0, JSON.stringify(carved));
    await panel.getByText('ChainMail', { exact: true }).click();
    await tissueIs('chainmail');
    assert.ok(await material.getByText('Softness').isVisible());
    assert.ok((await compare(page))!.same);
});
