// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The page around the views: keyboard, help, tour, labels, themes, small screens.

import assert from 'node:assert/strict';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import type { Vec3 } from '../src/maths/vec.ts';
import { kCoarseFormat, kCoarseStep } from '../src/net/protocol.ts';
import type { Session } from '../src/tools/session.ts';
import type { StageHooks } from '../src/views/stage.ts';
import { kPictures, picture, pixels, rectOf, spot, stateOf, still, visit } from './browser.ts';
import { browser, page, served, useOnePage } from './one_page.ts';

useOnePage();

test('the question mark shows all keys, Esc closes', async () => {
    await page.keyboard.press('?');
    const help = page.locator('dialog.help');
    assert.ok(await help.isVisible());
    assert.match((await help.textContent()) ?? '', /Ctrl\+Z.*undo/s);
    await picture(page, 'help');
    const box = (await help.boundingBox())!;
    assert.ok(box.height <= 720 && box.y >= 0);
    await page.keyboard.press('Escape');
    assert.ok(!(await help.isVisible()));
});

test('every control and every view has a name', async () => {
    const nameless = await page.evaluate(() => {
        for (const d of document.querySelectorAll('details')) d.open = true;
        const controls = document.querySelectorAll<HTMLElement>('button, input, select, a');
        return [...controls]
            .filter((e) => {
                const labels = (e as HTMLInputElement).labels;
                const legend = e.closest('fieldset')?.querySelector('legend');
                const text = e.textContent || e.getAttribute('aria-label');
                return !text && !labels?.length && !legend;
            })
            .map((e) => e.outerHTML);
    });
    assert.deepEqual(nameless, []);
    const views = page.locator('.view[aria-label]');
    assert.equal(await views.count(), 4);
    await picture(page, 'panels');
    await page.locator('.panels').evaluate((e) => e.scrollTo(0, 10_000));
    await picture(page, 'panels_end');
    await page.locator('.panels').evaluate((e) => e.scrollTo(0, 0));
});

test('a force is shown in newtons; energies of tissue without forces with the times', async () => {
    const shown = (force_n: number, energy_per_mm: number): Promise<(string | null)[]> =>
        page.evaluate(
            async (hands) => {
                (window as never as { pliant: Session }).pliant.store.set({ hands });
                await new Promise((drawn) => setTimeout(drawn, 200));
                const bar = document.querySelector<HTMLElement>('.force')!;
                if (bar.hidden) return [];
                return [
                    bar.title,
                    bar.getAttribute('aria-valuetext'),
                    bar.textContent,
                    bar.querySelector('i')!.style.width,
                ];
            },
            { force_n, energy_per_mm },
        );
    const newtons = 'force 0.999 N';
    assert.deepEqual(await shown(0.999, 99), [newtons, newtons, '1.00 N', '60%']);
    await picture(page, 'force');
    assert.deepEqual(await shown(0, 99), []);
    await page.keyboard.press('t');
    await page.locator('#times', { hasText: 'energy 99.0 per mm' }).waitFor();
    await page.keyboard.press('t');
    assert.deepEqual(await shown(0, 0), []);
});

test('the keyboard alone can choose, scroll, push and undo', async () => {
    await page.mouse.move(1200, 3);
    await page.locator('.view.endoscope').focus();
    await page.keyboard.press('F6');
    assert.equal((await stateOf(page)).pointer.active, 'axial');
    await page.keyboard.press('3');
    assert.equal((await stateOf(page)).tool.name, 'push');
    await page.keyboard.press('BracketRight');
    assert.equal((await stateOf(page)).tool.radius, 5);
    const before = await stateOf(page);
    await page.evaluate(() => {
        const { store } = (window as never as { pliant: Session }).pliant;
        const { cursor } = store.state.sections;
        store.set({ sections: { cursor: [cursor[0] + 9, cursor[1], cursor[2]] } });
    });
    await page.keyboard.press('Alt+ArrowLeft');
    await page.waitForFunction(
        (step) => (window as never as { pliant: Session }).pliant.store.state.shared!.step > step,
        before.shared!.step,
    );
    await page.keyboard.press('Control+z');
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.shared!.undo.steps === 0,
    );
    // Tab reaches every control, in each panel.
    const closed = await page.evaluate(() => {
        const panels = [...document.querySelectorAll<HTMLDetailsElement>('.panels details')];
        const shut = panels.filter((panel) => !panel.open);
        for (const panel of shut) panel.open = true;
        const wanted = [
            ...document.querySelectorAll<HTMLElement>('button, input, select, summary, .view'),
        ].filter(
            (e) =>
                e.checkVisibility({ visibilityProperty: true }) &&
                !e.matches(':disabled, [type=file], [type=radio]:not(:checked)'),
        );
        for (const e of wanted) e.dataset.missed = '';
        document.addEventListener('focusin', ({ target }) => {
            delete (target as HTMLElement).dataset.missed;
        });
        return shut.map((panel) => panel.querySelector('summary')!.textContent!);
    });
    const missed = page.locator('[data-missed]');
    const count = await missed.count();
    assert.ok(count > 120, `${count} controls`);
    await page.locator('.view.axial').focus();
    for (let i = 0; i < 2 * count && (await missed.count()); ++i) await page.keyboard.press('Tab');
    assert.deepEqual(await missed.evaluateAll((all) => all.map((e) => e.outerHTML)), []);
    await page.evaluate((titles) => {
        for (const panel of document.querySelectorAll<HTMLDetailsElement>('.panels details'))
            if (titles.includes(panel.querySelector('summary')!.textContent!)) panel.open = false;
    }, closed);
    await page.locator('.view.axial').focus();
    await page.keyboard.press('1');
});

test('typing a number into a field neither flies nor changes the tool', async () => {
    const {
        view: { camera },
        tool: { name: tool },
    } = await stateOf(page);
    const field = page.getByLabel('Level, number');
    await field.click();
    await field.fill('');
    await page.keyboard.type('-345');
    await page.keyboard.press('Enter');
    const state = await stateOf(page);
    assert.equal(state.sections.level, -345);
    assert.equal(state.tool.name, tool);
    assert.deepEqual(state.view.camera.eye, camera.eye);
    await page.locator('.view.axial').focus();
    await page.keyboard.press('Control+z');
    assert.equal((await stateOf(page)).sections.level, -200);
});

test('value, place and index under the pointer; LPS and RAS differ in two signs', async () => {
    await page.mouse.move(...(await spot(page, 'coronal', 0.5, 0.6)));
    const shown = async (space: string): Promise<string> => {
        const line = page.locator('#pointer', { hasText: `${space} ` });
        await line.waitFor();
        return (await line.textContent())!;
    };
    await page.keyboard.press('g');
    const ras = await shown('RAS');
    await page.keyboard.press('g');
    const lps = await shown('LPS');
    const numbers = (text: string, space: string): number[] => {
        assert.match(text, /^-?\d+ HU · /);
        const found = new RegExp(`${space} (\\S+), (\\S+), (\\S+) mm · ijk`).exec(text);
        assert.ok(found, text);
        return found.slice(1, 4).map(Number);
    };
    const [x, y, z] = numbers(lps, 'LPS');
    assert.deepEqual(numbers(ras, 'RAS'), [-x! + 0, -y! + 0, z]);
});

test('light and dark', async () => {
    await page.evaluate(() =>
        (window as never as { pliant: Session }).pliant.store.set({ display: { theme: 'dark' } }),
    );
    const dark = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    await picture(page, 'dark');
    await page.evaluate(() =>
        (window as never as { pliant: Session }).pliant.store.set({ display: { theme: 'light' } }),
    );
    const light = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    assert.notEqual(dark, light);
});

test('the real look gives way to the plain one where it is slow, unless chosen', async () => {
    const afterSlowFrame = (styleChosen: boolean): Promise<string> =>
        page.evaluate((chosen) => {
            const { stage, store } = (window as never as { pliant: Session }).pliant;
            store.set({ look: { style: 'real', styleChosen: chosen } });
            (stage as never as { hooks: StageHooks }).hooks.onTooSlow();
            return store.state.look.style;
        }, styleChosen);
    assert.equal(await afterSlowFrame(true), 'real');
    assert.equal(await afterSlowFrame(false), 'plain');
    const field = page.getByRole('group', { name: 'Field', exact: true, includeHidden: true });
    const octagon = field.locator('label', { hasText: 'octagon' });
    await octagon.waitFor({ state: 'hidden' });
    await page.locator('label', { hasText: /^real$/ }).click();
    await octagon.click();
    assert.equal((await stateOf(page)).look.fieldStop, 'octagon');
    assert.equal(await afterSlowFrame(true), 'real');
});

test('a coarse scan is shown in all views until the voxels are there', async () => {
    await still(page);
    const views = ['endoscope', 'axial'] as const;
    const seen = async (): Promise<{ hash: number; mean: number }[]> => {
        const found = [];
        for (const view of views) found.push(await pixels(page, view));
        return found;
    };
    const full = await seen();
    await page.evaluate(
        ([format, step]) => {
            const session = (window as never as { pliant: Session }).pliant;
            const { grid, halves } = session.volume!;
            session.store.set({ scan: { loaded: 0 } });
            const [nx, ny, nz] = grid.size.map((n) => Math.ceil(n / step!)) as unknown as Vec3;
            // In two parts, as from a server.
            for (const [low, high] of [
                [0, 5],
                [5, nz],
            ] as const) {
                const values: number[] = [];
                for (let k = low; k < high; ++k)
                    for (let j = 0; j < ny; ++j)
                        for (let i = 0; i < nx; ++i)
                            values.push(
                                halves[step! * (i + grid.size[0] * (j + grid.size[1] * k))]!,
                            );
                session.coarseBox({
                    kind: 'box',
                    format: format!,
                    step: 0,
                    volume: 1,
                    last: high === nz,
                    box: { begin: [0, 0, low], end: [nx, ny, high] },
                    halves: new Uint16Array(values),
                });
            }
        },
        [kCoarseFormat, kCoarseStep] as const,
    );
    const coarse = await seen();
    await picture(page, 'coarse');
    await page.evaluate(() =>
        (window as never as { pliant: Session }).pliant.store.set({ scan: { loaded: 1 } }),
    );
    const again = await seen();
    views.forEach((view, i) => {
        assert.equal(again[i]!.hash, full[i]!.hash, view);
        assert.notEqual(coarse[i]!.hash, full[i]!.hash, view);
        const off = Math.abs(coarse[i]!.mean - full[i]!.mean);
        assert.ok(off < 0.2 * full[i]!.mean, `${view}: mean ${coarse[i]!.mean}`);
    });
});

test('a saved picture has the marks of the views, and the name of the scan', async () => {
    await still(page);
    const coming = page.waitForEvent('download');
    await page.keyboard.press('p');
    const download = await coming;
    assert.match(download.suggestedFilename(), /^(mock_tube|airway_phantom)_views\.png$/);
    const bytes = await readFile((await download.path())!);
    await writeFile(join(kPictures, 'saved.png'), bytes);
    const marked = await page.evaluate(async (text) => {
        const image = new Image();
        image.src = `data:image/png;base64,${text}`;
        await image.decode();
        const canvas = document.querySelector('canvas')!;
        const dataOf = (source: CanvasImageSource): Uint8ClampedArray => {
            const copy = document.createElement('canvas');
            copy.width = canvas.width;
            copy.height = canvas.height;
            const context = copy.getContext('2d')!;
            context.drawImage(source, 0, 0);
            return context.getImageData(0, 0, copy.width, copy.height).data;
        };
        const [saved, shown] = [dataOf(image), dataOf(canvas)];
        let differ = 0;
        for (let i = 0; i < saved.length; i += 4)
            if (Math.abs(saved[i + 1]! - shown[i + 1]!) > 60) ++differ;
        return differ;
    }, bytes.toString('base64'));
    assert.ok(marked > 1000, `${marked} pixels of marks`);
});

test('times are shown on request', async () => {
    assert.ok(!(await page.locator('#times').isVisible()));
    await page.keyboard.press('t');
    await page.waitForFunction(() => document.querySelector('#times')!.textContent);
    assert.match((await page.locator('#times').textContent())!, /solve .* resample .* p50/);
    await page.keyboard.press('t');
});

test('at 1280×720 nothing is cut off, and a smaller window keeps its views', async () => {
    for (const [width, height] of [
        [1280, 720],
        [1024, 600],
    ] as const) {
        await page.setViewportSize({ width, height });
        const wide = await page.evaluate(() => [
            document.documentElement.scrollWidth,
            document.documentElement.scrollHeight,
        ]);
        assert.ok(wide[0]! <= width && wide[1]! <= height, `${wide} in ${width}×${height}`);
        for (const view of ['endoscope', 'axial', 'coronal', 'sagittal'] as const) {
            const box = await rectOf(page, view);
            assert.ok(box.width > 250 && box.height > 200, `${view}: ${box.width}×${box.height}`);
        }
    }
    await picture(page, 'small');
    await page.setViewportSize({ width: 1280, height: 720 });
});

test('the tour is shown once, has four steps, and can be skipped', async () => {
    const first = await visit(browser, served.link, '');
    const tour = first.page.locator('.tour');
    assert.ok(await tour.isVisible());
    await picture(first.page, 'tour');
    assert.match((await tour.textContent())!, /1 of 4/);
    await first.page.locator('.view.endoscope').focus();
    await first.page.keyboard.down('w');
    await first.page.waitForFunction(
        () => document.querySelector('.tour')!.textContent!.includes('2 of 4'),
        undefined,
        { timeout: 30_000 },
    );
    await first.page.keyboard.up('w');
    await tour.getByText('Next').click();
    await tour.getByText('Next').click();
    await tour.getByText('Done').click();
    assert.ok(!(await tour.isVisible()));
    await first.page.reload();
    await first.page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant?.store.state.scan.loaded === 1,
        undefined,
        { timeout: 60_000 },
    );
    assert.ok(!(await tour.isVisible()));
    assert.deepEqual(first.errors, []);
    await first.page.context().close();
});

test('the content security policy refuses foreign code, styles and connections', async () => {
    const stranger = await visit(browser, served.link);
    assert.deepEqual(stranger.errors, []);
    const ran = await stranger.page.evaluate(async () => {
        const trap = window as unknown as { ran: string[] };
        trap.ran = [];
        const script = document.createElement('script');
        script.textContent = 'window.ran.push("script")';
        document.body.append(script);
        const button = document.createElement('button');
        button.setAttribute('onclick', 'window.ran.push("handler")');
        document.body.append(button);
        button.click();
        const style = document.createElement('style');
        style.textContent = 'body { outline-width: 7px }';
        document.head.append(style);
        if (getComputedStyle(document.body).outlineWidth === '7px') trap.ran.push('style');
        const image = new Image();
        image.src = 'http://192.0.2.1/picture.png'; // no machine has this address
        await new Promise((resolve) => (image.onerror = image.onload = resolve));
        await fetch('http://192.0.2.1/').then(
            () => trap.ran.push('fetch'),
            () => undefined,
        );
        try {
            trap.ran.push(String(new Function('return "eval"')()));
        } catch {
            // as it should be
        }
        return trap.ran;
    });
    assert.deepEqual(ran, []);
    const refused = (): string[] =>
        stranger.errors
            .flatMap((error) => /^policy: (\S+)/.exec(error)?.[1] ?? [])
            .sort();
    const expected = [
        'connect-src',
        'img-src',
        'script-src',
        'script-src-attr',
        'script-src-elem',
        'style-src-elem',
    ];
    for (let n = 0; n < 50 && refused().length < expected.length; ++n)
        await stranger.page.waitForTimeout(100); // events come after the refusals
    assert.deepEqual(refused(), expected);
    await stranger.page.context().close();
});
