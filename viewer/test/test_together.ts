// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Several people in one scene: they follow each other's cameras, see their names, and are invited
// by a link and its QR code.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import jsQR from 'jsqr';
import type { Browser, Page } from 'playwright-core';
import type { Camera } from '../src/maths/rays.ts';
import { norm, sub, type Vec3 } from '../src/maths/vec.ts';
import { invitingLink } from '../src/panels/invitation.ts';
import { cameraBetween } from '../src/tools/follow.ts';
import type { Session } from '../src/tools/session.ts';
import {
    dragBy,
    launch,
    picture,
    serveAirway,
    type Served,
    spot,
    stateOf,
    untilState,
    visit,
} from './browser.ts';

let browser: Browser;
let served: Served;
let anna: Page;
let ben: Page;
const errors: string[][] = [];

async function join(name: string, more = ''): Promise<Page> {
    const visited = await visit(browser, served.link, `&notour&name=${name}${more}`);
    errors.push(visited.errors);
    await visited.page.locator('summary', { hasText: 'Session' }).click();
    return visited.page;
}

before(async () => {
    browser = await launch();
    served = await serveAirway(48);
    anna = await join('Anna');
    ben = await join('Ben', '&role=view');
});
after(async () => {
    await browser.close();
    await served.stop();
    assert.deepEqual(errors.flat(), []);
});

const cameraOf = async (page: Page): Promise<Camera> => (await stateOf(page)).view.camera;

/// Goes to a camera, as a tool does.
const goTo = (page: Page, eye: Vec3, look: Vec3): Promise<void> =>
    page.evaluate(
        ([e, l]) => (window as unknown as { pliant: Session }).pliant.endoscope.goTo(e!, l!),
        [eye, look],
    );

const kEqual = 1e-3; // [mm], and of unit vectors

const distance = (a: Camera, b: Camera): number => norm(sub(a.eye, b.eye));

async function untilSame(a: Page, b: Page): Promise<void> {
    for (const end = Date.now() + 15_000; ; await a.waitForTimeout(100)) {
        const [x, y] = [await cameraOf(a), await cameraOf(b)];
        if (distance(x, y) < kEqual && norm(sub(x.look, y.look)) < kEqual) return;
        assert.ok(Date.now() < end, `cameras differ: ${JSON.stringify([x, y])}`);
    }
}

const followButton = (page: Page, name: string) =>
    page.getByRole('button', { name: `Follow ${name}`, exact: true });
const message = (page: Page): Promise<string> => page.locator('.message').innerText();

test('a camera between two others is between them, and arrives', () => {
    const from: Camera = { eye: [0, 0, 0], look: [1, 0, 0], up: [0, 0, 1] };
    const to: Camera = { eye: [10, 0, 0], look: [0, 1, 0], up: [0, 0, 1] };
    const half = cameraBetween(from, to, 0.5);
    assert.deepEqual(half.eye, [5, 0, 0]);
    assert.ok(Math.abs(norm(half.look) - 1) < 1e-12 && half.look[0] === half.look[1]);
    let camera = from;
    for (let n = 0; n < 100; ++n) camera = cameraBetween(camera, to, 0.3);
    assert.ok(norm(sub(camera.eye, to.eye)) < kEqual && norm(sub(camera.look, to.look)) < kEqual);
    assert.equal(cameraBetween(camera, to, 0.3), camera, 'at rest');
    const back = cameraBetween(from, { ...from, look: [-1, 0, 0] }, 0.5);
    assert.deepEqual(back.look, [-1, 0, 0], 'opposite directions');
});

test('who views follows who controls, until an own look', async () => {
    const start = await cameraOf(anna);
    assert.ok(await followButton(ben, 'Ben').isHidden(), 'nobody follows himself');
    await followButton(ben, 'Anna').focus();
    await ben.keyboard.press('Enter');
    assert.equal(await followButton(ben, 'Anna').getAttribute('aria-pressed'), 'true');
    assert.match(
        await ben.locator('.following').innerText(),
        /^following Anna; any own flight or look ends it$/,
    );
    const { eye } = start;
    await goTo(anna, [eye[0], eye[1], eye[2] + 5], [0.6, 0.8, 0]);
    await untilSame(anna, ben);
    await picture(ben, 'following');
    await dragBy(ben, await spot(ben, 'endoscope'), [40, 10]);
    await untilState(ben, ({ company }) => company.leader === 0, 5);
    assert.ok(await ben.locator('.following').isHidden());
    assert.equal(await followButton(ben, 'Anna').getAttribute('aria-pressed'), 'false');
    assert.match(await message(ben), /you no longer follow Anna/);
    const own = await cameraOf(ben);
    await goTo(anna, eye, start.look);
    await ben.waitForTimeout(500);
    assert.deepEqual(await cameraOf(ben), own);
});

test('an own flight ends it too, and windows stay the own ones', async () => {
    await followButton(ben, 'Anna').click();
    await untilSame(anna, ben);
    await ben.evaluate(() =>
        (window as unknown as { pliant: Session }).pliant.store.set({ sections: { window: 777 } }),
    );
    assert.notEqual((await stateOf(ben)).company.leader, 0);
    assert.notEqual((await stateOf(anna)).sections.window, 777);
    await ben.locator('.view.endoscope').focus();
    await ben.keyboard.down('w');
    await untilState(ben, ({ company }) => company.leader === 0, 5);
    await ben.keyboard.up('w');
});

test('two pages that follow each other come to rest at one camera', async () => {
    await followButton(ben, 'Anna').click();
    await untilSame(anna, ben);
    await followButton(anna, 'Ben').click();
    await untilState(anna, ({ company }) => company.leader !== 0, 5);
    await untilSame(anna, ben);
    // The last hundredths of a millimetre take a few pictures more.
    let [before, rest] = [await cameraOf(ben), await cameraOf(anna)];
    for (let n = 0; n < 20 && JSON.stringify(before) !== JSON.stringify(rest); ++n) {
        before = rest;
        await ben.waitForTimeout(200);
        rest = await cameraOf(anna);
    }
    await ben.waitForTimeout(500);
    assert.deepEqual(await cameraOf(anna), rest);
    await followButton(anna, 'Ben').click();
    await followButton(ben, 'Anna').click();
    await untilState(ben, ({ company }) => company.leader === 0, 5);
});

test('names are at the tools of others, and can be hidden', async () => {
    const { eye } = await cameraOf(anna);
    await goTo(ben, [eye[0], eye[1], eye[2] + 4], [0, 0, -1]);
    await untilState(anna, ({ hands }) => hands.others.length > 0, 10);
    const names = anna.locator('.view.axial text.user');
    await names.first().waitFor({ state: 'attached' });
    assert.deepEqual(await names.allTextContents(), ['Ben']);
    await picture(anna, 'names');
    await anna.getByLabel('names at the tools of others').uncheck();
    await names.first().waitFor({ state: 'detached' });
    await anna.getByLabel('names at the tools of others').check();
});

test('a name can be changed, is kept, and a follower stays', async () => {
    await followButton(anna, 'Ben').click();
    await untilSame(ben, anna);
    const { step } = (await stateOf(ben)).shared!;
    const { client } = (await stateOf(ben)).link;
    await ben.getByLabel('Your name').fill('Benjamin the second');
    await ben.keyboard.press('Enter');
    await followButton(anna, 'Benjamin the second').waitFor();
    await untilState(ben, ({ link }) => link.status === 'open', 10);
    assert.equal((await stateOf(ben)).link.client, client);
    assert.equal((await stateOf(ben)).shared!.step, step);
    await anna.waitForTimeout(2000);
    assert.equal((await stateOf(anna)).company.leader, client);
    const { eye } = await cameraOf(ben);
    await goTo(ben, [eye[0] + 1, eye[1], eye[2]], [0, 0.6, 0.8]);
    await untilState(anna, ({ company }) => company.leader !== 0, 5);
    await untilSame(anna, ben);
    assert.equal(
        await ben.evaluate(() => localStorage.getItem('pliant.name')),
        'Benjamin the second',
    );
});

test('the end of the leader is said', async () => {
    const carl = await join('Carl');
    await followButton(anna, 'Carl').click();
    await untilSame(carl, anna);
    await carl.context().close();
    await untilState(anna, ({ company }) => company.leader === 0, 10);
    assert.match(await message(anna), /Carl has left: you no longer follow/);
});

test('the QR code is the link, in both themes', async () => {
    for (const [page, theme] of [
        [anna, 'dark'],
        [ben, 'light'],
    ] as const) {
        await page.evaluate(
            (wanted) =>
                (window as unknown as { pliant: Session }).pliant.store.set({
                    display: { theme: wanted },
                }),
            theme,
        );
        await page.getByRole('button', { name: 'Invite…' }).click();
        const link = await page.getByLabel('Link to this scene').inputValue();
        const token = new URL(served.link).hash;
        const expected = page === ben ? `${token}&role=view` : token;
        assert.equal(new URL(link).hash, expected);
        await page.locator('.qr').scrollIntoViewIfNeeded();
        const { data, size } = await page.locator('.qr').evaluate(async (code) => {
            const image = new Image();
            const text = new XMLSerializer().serializeToString(code);
            image.src = `data:image/svg+xml,${encodeURIComponent(text)}`;
            await image.decode();
            const canvas = document.createElement('canvas');
            canvas.width = canvas.height = 400;
            const context = canvas.getContext('2d')!;
            context.drawImage(image, 0, 0, 400, 400);
            return { data: [...context.getImageData(0, 0, 400, 400).data], size: 400 };
        });
        assert.equal(jsQR(new Uint8ClampedArray(data), size, size)?.data, link);
        await picture(page, `invite_${theme}`);
        await page.getByRole('button', { name: 'Invite…' }).click();
    }
});

test('a link for others has no settings of its own client', () => {
    const own = 'https://class.example.org/pliant/?a=1#token=ab-c_1&name=Anna&notour';
    assert.equal(invitingLink(own), 'https://class.example.org/pliant/?a=1#token=ab-c_1');
});
