// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Label maps in the page: colours in all views, names, moving with the tissue, structures at risk,
// targets behind walls. Marks are shared with another client.

import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import { type Grid, voxelCount, worldFromVoxel } from '../src/maths/grid.ts';
import { add, along, norm, sub, type Vec3 } from '../src/maths/vec.ts';
import { readNames } from '../src/state/labels.ts';
import type { Session } from '../src/tools/session.ts';
import { isLabelMap } from '../src/tools/label_guess.ts';
import { picture, pixels, rectOf, stateOf, still, untilState, visit } from './browser.ts';
import { browser, page, served, useOnePage } from './one_page.ts';

useOnePage({ expected: 'status of 400' });

test('label maps are known by their names, and tables of names are read', () => {
    for (const name of ['a.seg.nrrd', 'thorax-label.nrrd', 'x_labels.nii.gz', 'a.segmentation.mha'])
        assert.ok(isLabelMap(name), name);
    for (const name of ['thorax.nrrd', 'segments.nii.gz', 'label.txt', 'labels_ct.nrrd'])
        assert.ok(!isLabelMap(name), name);
    const table = '# Color table\n1 left_lung 128 174 128 255\n300 "heart" 1 2 3 4\n';
    assert.deepEqual(readNames(table, 'a'), { 1: 'left lung', 300: '"heart"' });
    assert.deepEqual(readNames('value,name\r\n3,"aorta"\r\n', 'a'), { 3: 'aorta' });
    assert.throws(() => readNames('nothing', 'x.ctbl'), /^Error: x\.ctbl: expected lines/);
});

/// Writes a label map on the scan's grid. @returns the file
function labelFile(grid: Grid, valueAt: (x: Vec3) => number): string {
    const bytes = Buffer.alloc(voxelCount(grid));
    const [nx, ny, nz] = grid.size;
    for (let k = 0; k < nz; ++k)
        for (let j = 0; j < ny; ++j)
            for (let i = 0; i < nx; ++i)
                bytes[i + nx * (j + ny * k)] = valueAt(worldFromVoxel(grid, [i, j, k]));
    const axes = grid.direction.map((d, a) => `(${d.map((x) => x * grid.spacing[a]!).join(',')})`);
    const head = [
        'NRRD0005',
        'type: uint8',
        'dimension: 3',
        'space: left-posterior-superior',
        `sizes: ${grid.size.join(' ')}`,
        `space directions: ${axes.join(' ')}`,
        `space origin: (${grid.origin.join(',')})`,
        'endian: little',
        'encoding: raw',
        'Segment0_LabelValue:=3',
        'Segment0_Name:=tumour',
    ].join('\n');
    const file = join(tmpdir(), `pliant-${process.pid}-label.nrrd`);
    writeFileSync(file, Buffer.concat([Buffer.from(`${head}\n\n`), bytes]));
    return file;
}

const panel = (): ReturnType<Page['locator']> =>
    page.locator('.panels details', { has: page.locator('summary', { hasText: /^Labels$/ }) });

const labelAt = (place: Vec3): Promise<string> =>
    page.evaluate((p) => {
        const { labelMap } = (window as never as { pliant: Session }).pliant;
        const label = labelMap.at(p as Vec3);
        return label ? String(label.value) : '';
    }, place);

const kUnsure = 2; // [mm]
let place: Vec3; // in tissue beside the lumen: the middle of the ball of label 3

test('a label map is opened over the scan, in colours in all views', async () => {
    const { scan } = await stateOf(page);
    const { size, spacing_mm, origin_mm, direction, landmarks } = scan.volume!;
    const grid = { size, spacing: spacing_mm, origin: origin_mm, direction };
    const before = await pixels(page, 'axial');
    const inside = await pixels(page, 'endoscope');
    place = await page.evaluate((near) => {
        // The first tissue to the left of the landmark, and 6 mm more.
        const session = (window as never as { pliant: Session }).pliant;
        const p = [...(near as Vec3)] as [number, number, number];
        while (session.isInTissue(p)) p[0] += 0.5;
        while (!session.isInTissue(p)) p[0] += 0.5;
        p[0] += 6;
        return p as Vec3;
    }, landmarks[0]!.point_mm);
    const file = labelFile(grid, (x) => (norm(sub(x, place)) < 7 ? 3 : x[1] < -20 ? 9 : 0));
    await panel().locator('summary').click();
    await page.setInputFiles('input[aria-label="labels file"]', file);
    await untilState(page, ({ labels }) => labels.list.length === 2 && labels.version > 1);
    await page.evaluate((p) => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({ sections: { cursor: p as Vec3 } });
    }, place);
    await still(page);
    assert.deepEqual(
        (await stateOf(page)).labels.list.map(({ value, name }) => [value, name]),
        [
            [3, 'tumour'],
            [9, ''],
        ],
    );
    assert.equal(await labelAt(place), '3');
    assert.equal(await labelAt(add(place, [9, 0, 0])), '');
    const coloured = await pixels(page, 'axial');
    await picture(page, 'labels');
    await panel().getByRole('button', { name: 'Hide all' }).click();
    const plain = await pixels(page, 'axial');
    assert.notEqual(coloured.hash, plain.hash);
    assert.notEqual(before.hash, coloured.hash);
    await panel().getByLabel('show tumour').check();
    await panel().getByLabel('outlines in the sections').uncheck();
    const filled = await pixels(page, 'axial');
    await panel().getByLabel('outlines in the sections').check();
    assert.notEqual((await pixels(page, 'axial')).hash, filled.hash);
    await panel().getByRole('button', { name: 'Show all' }).click();
    assert.equal((await pixels(page, 'axial')).hash, coloured.hash);
    assert.ok(inside.hash !== 0);
    // Named at the pointer, by the file or by the value.
    assert.match((await page.locator('#pointer').textContent())!, / · tumour · /);
    const names = join(tmpdir(), `pliant-${process.pid}-names.ctbl`);
    writeFileSync(names, '9 back_of_the_scan 1 2 3 255\n');
    await page.setInputFiles('input[aria-label="labels file"]', names);
    await panel().getByRole('button', { name: 'back of the scan' }).waitFor();
});

test('a bad label map is refused with a line, and the present one stays', async () => {
    const file = join(tmpdir(), `pliant-${process.pid}-bad-label.nrrd`);
    writeFileSync(file, 'NRRD0005\nnothing\n\n');
    await page.setInputFiles('input[aria-label="labels file"]', file);
    await page.locator('.message', { hasText: 'bad-label.nrrd' }).waitFor();
    assert.equal((await stateOf(page)).labels.list.length, 2);
});

test('the wall is tinted inside and from outside, and a target shimmers through it', async () => {
    // A look at the ball behind the wall, from inside of the lumen.
    await page.evaluate((p) => {
        const session = (window as never as { pliant: Session }).pliant;
        const eye = [...(p as Vec3)] as [number, number, number];
        while (session.isInTissue(eye)) eye[0] -= 0.5;
        eye[0] -= 4;
        const camera = { eye: eye as Vec3, look: [1, 0, 0] as Vec3, up: [0, 0, 1] as Vec3 };
        session.store.set({ view: { camera }, look: { style: 'plain' } });
    }, place);
    for (const style of ['plain', 'real'] as const) {
        await page.evaluate((s) => {
            const { store } = (window as never as { pliant: Session }).pliant;
            store.set({ look: { style: s } });
        }, style);
        const tinted = await pixels(page, 'endoscope');
        await picture(page, `labels_${style}`);
        await panel().getByRole('button', { name: 'Hide all' }).click();
        const plain = await pixels(page, 'endoscope');
        await panel().getByLabel('target tumour').check();
        const shimmer = await pixels(page, 'endoscope');
        await picture(page, `labels_target_${style}`);
        assert.notEqual(shimmer.hash, plain.hash, `${style}: the target`);
        await panel().getByLabel('target tumour').uncheck();
        assert.equal((await pixels(page, 'endoscope')).hash, plain.hash);
        await panel().getByRole('button', { name: 'Show all' }).click();
        assert.notEqual(tinted.hash, plain.hash, `${style}: the tint`);
    }
    await page.evaluate(() => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({ view: { outside: true } });
    });
    const outside = await pixels(page, 'endoscope');
    await picture(page, 'labels_outside');
    await panel().getByRole('button', { name: 'Hide all' }).click();
    assert.notEqual((await pixels(page, 'endoscope')).hash, outside.hash);
    await panel().getByRole('button', { name: 'Show all' }).click();
    await page.evaluate(() => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({ view: { outside: false }, look: { style: 'plain' } });
    });
});

test('a tool that touches a structure at risk warns at the hand', async () => {
    await panel().getByLabel('risk tumour').check();
    await page.evaluate((p) => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({
            tool: { name: 'push', radius: 2, strength: 0 },
            sections: { cursor: p as Vec3 },
        });
    }, place);
    await page.waitForTimeout(200);
    const at = await page.evaluate(() => {
        const drawing = document.querySelector('.view.axial svg')!;
        const box = drawing.getBoundingClientRect();
        const read = (kind: string, key: string): number =>
            Number(drawing.querySelector(`.${kind}`)!.getAttribute(key));
        return [box.left + read('along', 'x1'), box.top + read('across', 'y1')];
    });
    await page.mouse.move(at[0]!, at[1]!);
    await page.mouse.down();
    await untilState(page, ({ labels }) => labels.touched.join() === 'tumour', 10);
    await page.waitForTimeout(150);
    assert.equal(await page.locator('.view.axial text.risk').textContent(), 'touches tumour');
    assert.match((await page.locator('.message').textContent())!, /touches tumour/);
    await picture(page, 'labels_risk');
    await page.mouse.up();
    await untilState(page, ({ labels }) => labels.touched.length === 0, 10);
    // Away from it, nothing warns.
    const box = await rectOf(page, 'axial');
    await page.mouse.move(box.x + 0.9 * box.width, box.y + 0.5 * box.height);
    await page.mouse.down();
    await page.waitForTimeout(300);
    assert.deepEqual((await stateOf(page)).labels.touched, []);
    await page.mouse.up();
});

test('labels move with the tissue', async () => {
    const motion: Vec3 = [0, 0, 3];
    const done = await page.evaluate(
        async ([at, push]) => {
            const { connection } = (window as never as { pliant: Session }).pliant;
            const answer = await connection.ask({
                do: 'push',
                point: at as Vec3,
                push: push as Vec3,
                radius: 8,
            });
            await connection.ask({ do: 'release' });
            return answer as never as { step: number; step_fraction: number };
        },
        [place, motion] as const,
    );
    await page.waitForFunction(
        (step) => (window as never as { pliant: Session }).pliant.store.state.shared!.step >= step,
        done.step,
    );
    await page.waitForTimeout(500);
    await still(page);
    // Labels against the rest field, which tells the position at rest within kUnsure.
    await page.evaluate(() => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({ look: { style: 'real' } });
    });
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.stage.rest !== undefined,
    );
    await page.waitForTimeout(500);
    const { wrong, gone } = await page.evaluate(
        ([p, unsure]) => {
            const { stage } = (window as never as { pliant: Session }).pliant;
            const { grid } = stage.labels!;
            const [x, y, z] = p as Vec3;
            let [wrong, gone] = [0, 0];
            for (let k = -12; k <= 12; ++k)
                for (let j = -12; j <= 12; ++j)
                    for (let i = -12; i <= 12; ++i) {
                        const q = [x + i, y + j, z + k].map((v, a) =>
                            Math.round((v - grid.origin[a]!) / grid.spacing[a]!),
                        ) as never as Vec3;
                        const there = q.map((n, a) => grid.origin[a]! + n * grid.spacing[a]!);
                        const { offset } = stage.rest!.at(q);
                        const far = Math.hypot(...there.map((v, a) => v - offset[a]! - p[a]!));
                        if (Math.abs(far - 7) < unsure) continue;
                        const isIn = stage.labels!.numberAt(q) === 1;
                        if (isIn !== far < 7) ++wrong;
                        if (isIn !== Math.hypot(...there.map((v, a) => v - p[a]!)) < 7) ++gone;
                    }
            return { wrong, gone };
        },
        [place, kUnsure] as const,
    );
    console.log(`# labels: ${wrong} wrong, ${gone} moved`);
    assert.ok(wrong === 0 && gone > 20, `${wrong} wrong, ${gone} moved`);
    await page.evaluate(() =>
        (window as never as { pliant: Session }).pliant.connection.ask({ do: 'undo' }),
    );
    await page.waitForTimeout(500);
    assert.equal(await labelAt(along(place, 1, [0, 0, -6])), '3');
});

test('marks are shared with other clients; viewers keep their own', async () => {
    const other = await visit(browser, served.link, '&notour&name=Ben');
    const namesOf = (p: Page): Promise<string[]> =>
        p.evaluate(() =>
            (window as never as { pliant: Session }).pliant.store.state.marks.list.map(
                ({ name }) => name,
            ),
        );
    const click = (p: Page, x: number): Promise<void> =>
        p.evaluate((at) => {
            const { marks } = (window as never as { pliant: Session }).pliant;
            marks.choose('point');
            marks.click([at, 0, 0]);
        }, x);
    const until = async (p: Page, names: string[]): Promise<void> => {
        for (let n = 0; n < 100; ++n) {
            if (String(await namesOf(p)) === String(names)) return;
            await p.waitForTimeout(50);
        }
        assert.deepEqual(await namesOf(p), names);
    };
    await click(page, 1);
    await until(other.page, ['point 1']);
    await click(other.page, 2);
    await until(page, ['point 1', 'point 2']);
    // Each takes back its own steps.
    await page.locator('#undo').click();
    await until(other.page, ['point 2']);
    await page.locator('#redo').click();
    await until(other.page, ['point 2', 'point 1']);
    await other.page.evaluate(() => {
        const { marks, store } = (window as never as { pliant: Session }).pliant;
        marks.rename(store.state.marks.list[1]!.key, 'carina');
    });
    await until(page, ['point 2', 'carina']);
    // A viewer sees them; its own marks are not sent.
    const viewer = await visit(browser, served.link, '&notour&role=view');
    await until(viewer.page, ['point 2', 'carina']);
    await click(viewer.page, 3);
    await until(viewer.page, ['point 2', 'carina', 'point 1']);
    await page.waitForTimeout(200);
    await until(page, ['point 2', 'carina']);
    for (const { page: p, errors } of [other, viewer]) {
        assert.deepEqual(errors, []);
        await p.context().close();
    }
});
