// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Movies of keyframes: interpolation, file and panel.

import assert from 'node:assert/strict';
import { copyFileSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import {
    type Keyframe,
    lengthOf,
    readKeyframes,
    shotAt,
    timesOf,
    writeKeyframes,
} from '../src/maths/keyframes.ts';
import { dot, norm, normalized, sub, type Vec3 } from '../src/maths/vec.ts';
import type { Session } from '../src/tools/session.ts';
import { kPictures, picture, stateOf } from './browser.ts';
import { randomVector } from './fields.ts';
import { page, useOnePage } from './one_page.ts';
import { between } from './random.ts';

useOnePage();

const frame = (seconds: number, eye: Vec3, look: Vec3, up: Vec3, iso = -500): Keyframe => ({
    seconds,
    camera: { eye, look, up },
    fieldOfView: 80,
    iso,
    window: 1500,
    level: -200,
});

const randomFrames = (count: number): Keyframe[] =>
    Array.from({ length: count }, (_, i) => {
        const look = normalized(randomVector(1));
        const side = randomVector(1);
        const up = normalized(sub(side, look.map((x) => x * dot(side, look)) as never));
        return frame(i ? between(0.5, 4) : 0, randomVector(40), look, up, between(-900, 0));
    });

test('a movie passes its keyframes at their times, and never jumps', () => {
    for (let n = 0; n < 8; ++n) {
        const frames = randomFrames(2 + (n % 5));
        timesOf(frames).forEach((time, i) => {
            const { camera, iso } = shotAt(frames, time);
            assert.ok(norm(sub(camera.eye, frames[i]!.camera.eye)) < 1e-9);
            assert.ok(norm(sub(camera.look, frames[i]!.camera.look)) < 1e-9);
            assert.ok(norm(sub(camera.up, frames[i]!.camera.up)) < 1e-9);
            assert.ok(Math.abs(iso - frames[i]!.iso) < 1e-9);
        });
        let before = shotAt(frames, 0);
        const step = 1e-3;
        for (let time = step; time < lengthOf(frames) + 0.1; time += step) {
            const now = shotAt(frames, time);
            assert.ok(norm(sub(now.camera.eye, before.camera.eye)) < 0.8);
            assert.ok(norm(sub(now.camera.look, before.camera.look)) < 0.02);
            assert.ok(Math.abs(norm(now.camera.look) - 1) < 1e-9);
            assert.ok(Math.abs(dot(now.camera.look, now.camera.up)) < 1e-9);
            before = now;
        }
    }
});

test('half-way through a quarter turn is an eighth, and a straight path is flown evenly', () => {
    const frames = [
        frame(0, [0, 0, 0], [0, 1, 0], [0, 0, 1]),
        frame(2, [20, 0, 0], [1, 0, 0], [0, 0, 1]),
        frame(2, [40, 0, 0], [1, 0, 0], [0, 0, 1]),
    ];
    const { look, up, eye } = shotAt(frames, 1).camera;
    assert.ok(norm(sub(look, [Math.SQRT1_2, Math.SQRT1_2, 0])) < 1e-12);
    assert.ok(norm(sub(up, [0, 0, 1])) < 1e-12);
    assert.ok(norm(sub(eye, [10, 0, 0])) < 1e-12);
});

test('keyframes are read as written, and invalid ones are refused with a line', () => {
    const frames = randomFrames(4);
    const again = readKeyframes(writeKeyframes(frames), 'a');
    frames.forEach((f, i) => {
        assert.deepEqual(again[i]!.camera, f.camera);
        assert.ok(Math.abs(again[i]!.seconds - f.seconds) < 1e-12);
        assert.equal(again[i]!.iso, f.iso);
    });
    const good = JSON.parse(writeKeyframes(frames));
    const spoilt = (change: (file: never) => void): string => {
        const file = structuredClone(good);
        change(file as never);
        return JSON.stringify(file);
    };
    const bad: [string, RegExp][] = [
        ['{', /^x: expected keyframes \(JSON\)/],
        ['{}', /^x: what: expected/],
        [spoilt((f: any) => (f.version = 2)), /^x: version: expected 1/],
        [spoilt((f: any) => (f.keyframes = [])), /^x: keyframes: expected a list/],
        [spoilt((f: any) => (f.keyframes[2] = null)), /^x: keyframes\[2\]\.seconds/],
        [spoilt((f: any) => (f.keyframes[1].seconds = 0)), /^x: keyframes\[1\]\.seconds: expected/],
        [spoilt((f: any) => (f.keyframes[1].look = [0, 0, 0])), /^x: keyframes\[1\]\.look/],
        [spoilt((f: any) => (f.keyframes[3].eye_mm = [0, 1])), /^x: keyframes\[3\]\.eye_mm/],
        [spoilt((f: any) => delete f.keyframes[0].iso_hu), /^x: keyframes\[0\]\.iso_hu/],
    ];
    for (const [text, message] of bad)
        assert.throws(
            () => readKeyframes(text, 'x'),
            (e: Error) => message.test(e.message) && !e.message.includes('\n'),
        );
});

test('keyframes are added, ordered, played, recorded, saved and loaded', async () => {
    const session = (): Promise<Session['store']['state']> => stateOf(page);
    const fly = (by: number): Promise<void> =>
        page.evaluate((way) => {
            const { store } = (window as never as { pliant: Session }).pliant;
            const { camera } = store.state.view;
            const eye = camera.eye.map((x, a) => x + way * camera.look[a]!) as never;
            store.set({ view: { camera: { ...camera, eye } } });
        }, by);
    await page.locator('.panels summary', { hasText: 'Movie' }).click();
    const panel = page
        .locator('.panels details', { hasText: 'Keyframes' })
        .or(page.locator('.panels details', { has: page.locator('ol.keyframes') }));
    await panel.getByRole('button', { name: 'Add' }).click();
    await fly(6);
    await page.locator('.view.endoscope').focus();
    await page.keyboard.press('k');
    await fly(4);
    await page.keyboard.press('k');
    assert.equal((await session()).movie.keyframes.length, 3);
    assert.deepEqual(
        (await session()).movie.keyframes.map((f) => f.seconds),
        [0, 1, 1],
    );
    await panel.getByLabel('seconds to keyframe 3').fill('0.5');
    await panel.getByLabel('seconds to keyframe 3').press('Enter');
    assert.equal((await session()).movie.keyframes[2]!.seconds, 0.5);
    await picture(page, 'movie_panel');

    // The second keyframe moves to the front, and back.
    const eyes = (await session()).movie.keyframes.map((f) => f.camera.eye);
    await panel.getByRole('button', { name: '↑' }).nth(1).click();
    assert.deepEqual(
        (await session()).movie.keyframes.map((f) => f.camera.eye),
        [eyes[1], eyes[0], eyes[2]],
    );
    await panel.getByRole('button', { name: '↓' }).nth(0).click();
    assert.deepEqual(
        (await session()).movie.keyframes.map((f) => f.camera.eye),
        eyes,
    );
    await panel.getByLabel('go to keyframe 1').click();
    assert.deepEqual((await session()).view.camera.eye, eyes[0]);

    // A movie ends at the last keyframe; undo restores the camera.
    const ended = (): Promise<unknown> =>
        page.waitForFunction(
            () => !(window as never as { pliant: Session }).pliant.store.state.movie.playing,
            undefined,
            { timeout: 60_000 },
        );
    await page.locator('.view.endoscope').focus();
    await page.evaluate(() => {
        const { store } = (window as never as { pliant: Session }).pliant;
        const seen: string[] = [];
        (window as never as { seen: string[] }).seen = seen;
        store.listen(({ movie, view }) => {
            if (movie.playing) seen.push(view.camera.eye.join());
        });
    });
    await page.keyboard.press('Shift+K');
    await ended();
    const seen = await page.evaluate(() => (window as never as { seen: string[] }).seen);
    assert.ok(new Set(seen).size > 5, `${new Set(seen).size} places`);
    assert.ok(norm(sub((await session()).view.camera.eye, eyes[2]!)) < 1e-9);
    await page.keyboard.press('Control+z');
    assert.deepEqual((await session()).view.camera.eye, eyes[0]);
    // Steering ends the movie.
    await panel.getByLabel('seconds to keyframe 3').fill('600');
    await panel.getByLabel('seconds to keyframe 3').press('Enter');
    await page.locator('.view.endoscope').focus();
    await page.keyboard.press('Shift+K');
    assert.equal((await session()).movie.playing, true);
    await page.keyboard.down('ArrowLeft');
    await ended();
    await page.keyboard.up('ArrowLeft');
    assert.ok(norm(sub((await session()).view.camera.eye, eyes[2]!)) > 1);
    await panel.getByLabel('seconds to keyframe 3').fill('0.5');
    await panel.getByLabel('seconds to keyframe 3').press('Enter');

    // A recording has several pictures. It is longer, for machines that draw few pictures a second.
    for (const at of [2, 3]) {
        await panel.getByLabel(`seconds to keyframe ${at}`).fill('3');
        await panel.getByLabel(`seconds to keyframe ${at}`).press('Enter');
    }
    const [movie] = await Promise.all([
        page.waitForEvent('download', { timeout: 60_000 }),
        panel.getByRole('button', { name: 'Record' }).click(),
    ]);
    assert.match(movie.suggestedFilename(), /^pliant\.(mp4|webm)$/);
    // WebM begins with the EBML identifier, MP4 with a box named ftyp.
    const bytes = readFileSync(await movie.path());
    assert.ok(bytes.readUInt32BE(0) === 0x1a45dfa3 || bytes.toString('latin1', 4, 8) === 'ftyp');
    assert.ok(bytes.length > 1000, `${bytes.length} bytes`);
    copyFileSync(await movie.path(), join(kPictures, movie.suggestedFilename()));

    // Keyframes are saved, deleted and loaded.
    const [file] = await Promise.all([
        page.waitForEvent('download'),
        panel.getByRole('button', { name: 'Save' }).click(),
    ]);
    const saved = readKeyframes(readFileSync(await file.path(), 'utf8'), 'saved');
    assert.deepEqual(
        saved.map((f) => f.camera.eye),
        eyes,
    );
    await panel.getByRole('button', { name: '×' }).first().click();
    assert.equal((await session()).movie.keyframes.length, 2);
    assert.equal((await session()).movie.keyframes[0]!.seconds, 0);
    await page.setInputFiles('input[aria-label="keyframes file"]', {
        name: 'k.json',
        mimeType: 'application/json',
        buffer: Buffer.from(writeKeyframes(saved)),
    });
    await page.waitForFunction(
        () =>
            (window as never as { pliant: Session }).pliant.store.state.movie.keyframes.length ===
            3,
    );
});
