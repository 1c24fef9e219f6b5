// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Slabs in the sections: pixels are compared with projections that are computed here, by dense
// sampling of the page's mirror of the voxels.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { voxelFromWorld, voxelVector } from '../src/maths/grid.ts';
import { along, type Vec3 } from '../src/maths/vec.ts';
import type { VolumeData } from '../src/maths/volume.ts';
import { kProjections, kViews, type Projection, type SectionName } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import { sectionPlane, worldOfPixel } from '../src/views/section_geometry.ts';
import { pixels, stateOf, untilUndo } from './browser.ts';
import { mirrorOf, pixelsOf } from './mirror.ts';
import { page, useOnePage } from './one_page.ts';
import { whole } from './random.ts';

const kSections = kViews.slice(1) as SectionName[];
const kDense = 48; // samples per voxel
const kPixels = 60;

const set = (sections: object): Promise<void> =>
    page.evaluate(
        (s) => (window as never as { pliant: Session }).pliant.store.set({ sections: s }),
        sections,
    );

const cursor: Vec3 = [-6.9, -4.6, 19]; // in the wall of the airway
useOnePage({ size: 64, ready: () => set({ cursor, window: 1500, level: -300 }) });

/// Projection of a slab by brute force; voxels outside the scan don't count.
function projected(
    volume: VolumeData,
    p: Vec3,
    normal: Vec3,
    slab: number,
    projection: Projection,
): number {
    const d = voxelVector(volume.grid, normal);
    const rate = Math.max(...d.map(Math.abs));
    const count = Math.max(Math.ceil(slab * rate * kDense), 1);
    let [high, low, sum, seen] = [-Infinity, Infinity, 0, 0];
    for (let i = 0; i < count; ++i) {
        const q = along(p, slab * ((i + 0.5) / count - 0.5), d);
        if (q.some((x, a) => x < -0.5 || x > volume.grid.size[a]! - 0.5)) continue;
        const value = volume.sample(q);
        high = Math.max(high, value);
        low = Math.min(low, value);
        sum += value;
        ++seen;
    }
    return projection === 'maximum' ? high : projection === 'minimum' ? low : sum / seen;
}

/// Compares random pixels of the three sections. @returns the largest and the mean difference, of
/// 255
async function compare(slab: number, projection: Projection): Promise<[number, number]> {
    await set({ slab, projection });
    const volume = await mirrorOf(page);
    const { sections } = await stateOf(page);
    const { window, level, frames } = sections;
    let [most, sum] = [0, 0];
    for (const view of kSections) {
        const { width, height, data } = await pixelsOf(page, view);
        const plane = sectionPlane(volume.grid, view, frames[view], cursor, width, height);
        for (let n = 0; n < kPixels; ) {
            const [x, y] = [whole(0, width - 1), whole(0, height - 1)];
            const p = voxelFromWorld(volume.grid, worldOfPixel(plane, x + 0.5, y + 0.5));
            if (p.some((c, a) => c < 0 || c > volume.grid.size[a]! - 1)) continue;
            const value = projected(volume, p, plane.axes.normal, slab, projection);
            const grey = Math.min(Math.max((value - level) / window + 0.5, 0), 1);
            const off = Math.abs(data[4 * (y * width + x)]! - 255 * grey);
            most = Math.max(most, off);
            sum += off;
            ++n;
        }
    }
    return [most, sum / (kSections.length * kPixels)];
}

for (const projection of kProjections)
    test(`a slab's ${projection} is that of brute force, also at the scan's border`, async () => {
        for (const slab of [0.3, 5.3, 17, 1000]) {
            const [most, mean] = await compare(slab, projection);
            assert.ok(most < 2.5 && mean < 0.6, `${slab} mm: at most ${most}, mean ${mean}`);
        }
    });

test('a slab follows the tissue', async () => {
    const [, mean] = await compare(12, 'maximum');
    const earlier = await pixels(page, 'axial');
    await page.evaluate(
        (point) =>
            (window as never as { pliant: Session }).pliant.ask({
                do: 'push',
                point,
                push: [-6, 0, 0],
                radius: 4,
            }),
        cursor,
    );
    await untilUndo(page, 1);
    const [most, after] = await compare(12, 'maximum');
    assert.ok(most < 2.5 && after < 0.6, `at most ${most}, mean ${after} after ${mean}`);
    assert.notEqual((await pixels(page, 'axial')).hash, earlier.hash);
    await page.keyboard.press('Control+z');
    await untilUndo(page, 0);
    assert.equal((await pixels(page, 'axial')).hash, earlier.hash);
});

test('projections differ, and a slab of 0 mm is the plane', async () => {
    await set({ slab: 0 });
    const plane = await pixels(page, 'coronal');
    const seen = new Set([plane.hash]);
    for (const projection of kProjections) {
        await set({ slab: 8, projection });
        seen.add((await pixels(page, 'coronal')).hash);
    }
    assert.equal(seen.size, 4);
    await set({ slab: 0 });
    assert.equal((await pixels(page, 'coronal')).hash, plane.hash);
});

test('key U goes through the projections and back to the plane, and can be undone', async () => {
    await set({ slab: 0, projection: 'maximum' });
    const now = async (): Promise<string> => {
        const { slab, projection } = (await stateOf(page)).sections;
        return slab > 0 ? `${projection} ${slab}` : 'plane';
    };
    const found: string[] = [];
    for (let n = 0; n < 4; ++n) {
        await page.keyboard.press('u');
        found.push(await now());
        await page.waitForTimeout(800); // else they are one step of undo
    }
    assert.deepEqual(found, ['maximum 10', 'minimum 10', 'mean 10', 'plane']);
    await page.keyboard.press('Control+z');
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.sections.slab === 10,
    );
    assert.equal(await now(), 'mean 10');
    assert.match((await page.locator('.view.axial .caption').textContent())!, /mean of 10 mm/);
    await set({ slab: 0 });
});
