// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter in the phantom of a vessel: inserted by a key, shown in all views, in fluoroscopy and
// in a second browser, and replayed to the same checksum. Only with the program's server: the mock
// has no vessel.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import { cross, dot, norm, sub, type Vec3 } from '../src/maths/vec.ts';
import type { SharedState, VesselState } from '../src/net/protocol.ts';
import type { Session } from '../src/tools/session.ts';
import {
    compare,
    hasGpu,
    launch,
    picture,
    pixels,
    serve,
    type Served,
    stateOf,
    untilState,
    visit,
} from './browser.ts';

// A stiff catheter, inserted so far that 14 mm more push the wall. Time steps of 4 ms run at about
// real time.
const kScene = `
[vessel]
phantom = "bend"
thickness_mm = 1.5
layers = 1
[wall]
support_pa_per_mm = 2000
density_g_mm3 = 0.05
[catheter]
length_mm = 150
bend_n_mm2 = 200
tip_bend_n_mm2 = 100
[entry]
place_mm = [0, 0, 45]
direction = [0, 0, 1]
inserted_mm = 24
[simulation]
time_step_s = 0.004
`;

type Held = { pliant: Session };

/// Waits for a state of the vessel.
const untilVessel = (
    page: Page,
    holds: (vessel: VesselState, shared: SharedState) => boolean,
): Promise<void> =>
    untilState(page, ({ shared }) => Boolean(shared?.vessel && holds(shared.vessel, shared)));

/// The endoscope rides on the tip while the catheter is withdrawn and inserted again, until the
/// user looks around; undo goes back.
async function rides(page: Page): Promise<void> {
    const from = (await stateOf(page)).view;
    await page.keyboard.press('i');
    await untilState(page, ({ view }) => view.onTip && !view.outside);
    type Ride = { eye: Vec3; look: Vec3; tip: Vec3 };
    const isNear = ({ eye, look, tip }: Ride): boolean => {
        const way = sub(tip, eye);
        return norm(way) < 14 && dot(way, look) > 0.8 * norm(way);
    };
    /// Waits until the eye is behind the tip: it glides, and frames may be slow.
    const behindTip = async (holds: (eye: Vec3) => boolean = () => true): Promise<Vec3> => {
        for (const end = Date.now() + 30_000; ; await page.waitForTimeout(200)) {
            const ride = await page.evaluate(() => {
                const { vessel, store } = (window as never as Held).pliant;
                const { eye, look } = store.state.view.camera;
                return { eye, look, tip: vessel!.catheter.at(-1)! };
            });
            if (isNear(ride) && holds(ride.eye)) return ride.eye;
            assert.ok(Date.now() < end, `not behind the tip: ${JSON.stringify(ride)}`);
        }
    };
    const begin = await behindTip();
    await picture(page, 'catheter_ride');
    const { inserted_mm } = (await stateOf(page)).shared!.vessel!;
    await page.keyboard.down('ArrowDown');
    await untilVessel(page, (v) => v.insert_mm_s < 0);
    await page.waitForFunction(
        (most) => (window as never as Held).pliant.store.state.shared!.vessel!.inserted_mm < most,
        inserted_mm - 5,
    );
    await page.keyboard.up('ArrowDown');
    await untilVessel(page, (v, shared) => v.insert_mm_s === 0 && shared.settled);
    await behindTip((eye) => norm(sub(eye, begin)) > 2.5);
    await page.keyboard.press('q', { delay: 60 });
    await untilState(page, ({ view }) => !view.onTip);
    assert.match((await page.locator('.message').textContent())!, /no longer rides/);
    await page.keyboard.press('Control+z');
    await untilState(page, ({ view }) => view.onTip);
    // Before the ride's begin, undo takes the catheter's own steps back.
    for (let n = 0; n < 4 && (await stateOf(page)).view.onTip; ++n) {
        await page.keyboard.press('Control+z');
        await page.waitForTimeout(500);
    }
    assert.deepEqual((await stateOf(page)).view, from);
    await untilVessel(page, (v, shared) => v.inserted_mm >= inserted_mm - 0.1 && shared.settled);
}

test('a catheter is driven, seen and played again', async (t) => {
    const program = process.env.PLIANT_SERVER;
    if (!program) return t.skip('the mock has no vessel');
    const folder = mkdtempSync(join(tmpdir(), 'pliant-catheter-'));
    const scene = join(folder, 'bend.toml');
    const record = join(folder, 'bend.pls');
    writeFileSync(scene, kScene);
    const browser = await launch();
    let served: Served | undefined;
    try {
        served = await serve(scene, '--session', record);
        const { page, errors } = await visit(browser, served.link);
        await page.keyboard.press('8');
        assert.equal((await stateOf(page)).tool.name, 'catheter');
        // The first view is from outside, with the whole vessel in the picture and the tip in the
        // sections.
        await untilState(page, (state) => state.view.outside);
        const first = await page.evaluate(() => {
            const { vessel, store } = (window as never as Held).pliant;
            const { view, sections } = store.state;
            const { orbit } = view;
            const { cursor } = sections;
            return { orbit, cursor, tip: vessel!.catheter.at(-1)!, rest: [...vessel!.rest] };
        });
        assert.deepEqual(first.cursor, first.tip);
        const places = first.rest.flatMap((x, i, all): Vec3[] =>
            i % 3 ? [] : [[x, all[i + 1]!, all[i + 2]!]],
        );
        for (const p of [first.tip, ...places]) {
            const { centre, direction, up, distance } = first.orbit;
            const off = sub(p, centre);
            const half = (distance + dot(off, direction)) * Math.tan(Math.PI / 12);
            assert.ok(Math.abs(dot(off, up)) < half);
            assert.ok(Math.abs(dot(off, cross(direction, up))) < half);
        }
        await picture(page, 'catheter_first');
        await page.evaluate(() => {
            // Start of the bend, so that the sections show the pushed wall.
            (window as never as Held).pliant.store.set({ sections: { cursor: [1, 0, 68] } });
        });
        const look = async (): Promise<Record<'outside' | 'coronal', number>> => ({
            outside: (await pixels(page, 'endoscope')).hash,
            coronal: (await pixels(page, 'coronal')).hash,
        });
        const before = await look();
        assert.ok((await compare(page))!.same);
        await page.keyboard.down('ArrowUp');
        await untilVessel(page, (v) => v.insert_mm_s === 20);
        await untilVessel(page, (v) => v.inserted_mm >= 38);
        await page.keyboard.up('ArrowUp');
        await untilVessel(page, (v, { settled }) => v.insert_mm_s === 0 && settled);
        const { vessel } = (await stateOf(page)).shared!;
        assert.ok(vessel!.wall_moved_mm > 0.05, `${vessel!.wall_moved_mm} mm`);
        assert.ok(vessel!.depth_mm < 0.1 && vessel!.force_n !== 0 && vessel!.pace > 0);
        const after = await look();
        assert.notEqual(after.outside, before.outside);
        assert.notEqual(after.coronal, before.coronal);
        assert.ok((await page.locator('.view.coronal .catheter.near').count()) > 0);
        const said = await page.locator('dd[data-name="force on the hand"]').textContent();
        assert.match(said!, /^-?\d+\.\d{3} N$/);
        const counted = await page.locator('dd[data-name="sub-steps"]').textContent();
        assert.match(counted!, /^[1-9]\d* in a step$/);
        await picture(page, 'catheter_outside');

        await page.keyboard.press('b');
        const shadow = await pixels(page, 'endoscope');
        assert.notEqual(shadow.hash, after.outside);
        assert.ok(shadow.mean > 40 && shadow.mean < 250, `${shadow.mean}`);
        await picture(page, 'catheter_fluoroscopy');
        await page.keyboard.press('b');

        // The style real takes software seconds for a picture of the catheter.
        await page.evaluate(() => {
            const { store } = (window as never as Held).pliant;
            store.set({ look: { style: 'plain' } });
        });
        await rides(page);

        // A device holds it: 8 mm ahead and back in two seconds.
        if (hasGpu) {
            const panel = page.locator('details', {
                has: page.locator('summary', { hasText: /^Device$/ }),
            });
            await panel.locator('summary').click();
            await panel.getByLabel('Device', { exact: true }).selectOption('virtual:tap');
            await panel.getByRole('button', { name: 'Start' }).click();
            const base = vessel!.inserted_mm;
            await untilState(page, ({ device: { news }, shared }) =>
                Boolean(
                    news?.holds === 'catheter' &&
                    news.largest_n! > 0.005 &&
                    Math.abs(shared!.vessel!.inserted_mm - base) > 2,
                ),
            );
            assert.match((await panel.locator('.felt').textContent())!, /holds the catheter/);
            await picture(page, 'catheter_device');
            await page.keyboard.press('h');
            await untilState(page, ({ device }) => device.news!.stopped!);
            await panel.getByRole('button', { name: 'End' }).click();
            await untilVessel(page, (v, { settled }) => v.insert_mm_s === 0 && settled);
        }

        // A later client sees the same, and can't drive with the link for viewing.
        const sums = (await compare(page))!;
        assert.ok(sums.same);
        const other = await visit(browser, served.link, '&notour&role=view');
        const seen = (await compare(other.page))!;
        assert.ok(seen.same);
        assert.equal(seen.tissue, sums.tissue);
        const tips = await Promise.all(
            [page, other.page].map((p) =>
                p.evaluate(() => (window as never as Held).pliant.vessel!.catheter.at(-1)),
            ),
        );
        assert.deepEqual(tips[0], tips[1]);
        await other.page.keyboard.press('8');
        await other.page.keyboard.press('ArrowUp', { delay: 150 });
        const { inserted_mm } = (await stateOf(page)).shared!.vessel!;
        assert.equal((await stateOf(other.page)).shared!.vessel!.inserted_mm, inserted_mm);

        await served.stop();
        served = undefined;
        const replayed = execFileSync(program, ['replay', record], { encoding: 'utf8' });
        assert.ok(replayed.includes(sums.tissue), replayed);
        assert.deepEqual(
            [...errors, ...other.errors].filter((e) => !/WebSocket/.test(e)),
            [],
        );
    } finally {
        await browser.close();
        await served?.stop();
        rmSync(folder, { recursive: true });
    }
});
