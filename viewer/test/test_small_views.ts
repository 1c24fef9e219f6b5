// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Small views: captions, letters, bars of scale and the legend leave each other and the picture
// free.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Session } from '../src/tools/session.ts';
import { picture } from './browser.ts';
import { page, useOnePage } from './one_page.ts';

const kSections = ['axial', 'coronal', 'sagittal'] as const;
/// Four views of 370 × 270 pixels; a low window with a row of them; a phone.
const kWindows = [
    [1000, 640],
    [700, 480],
    [390, 844],
] as const;
useOnePage();

async function resize(width: number, height: number): Promise<void> {
    await page.setViewportSize({ width, height });
    await page.waitForTimeout(200);
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => setTimeout(done))));
}

test('captions, letters and bars of scale do not overlap, with a slab either', async () => {
    for (const [width, height] of kWindows)
        for (const slab of [0, 10]) {
            await page.evaluate((mm) => {
                const { store } = (window as never as { pliant: Session }).pliant;
                store.set({ sections: { slab: mm } });
            }, slab);
            await resize(width, height);
            for (const view of kSections) {
                const found = await page.evaluate((name) => {
                    const element = document.querySelector(`.view.${name}`)!;
                    const kinds = ['.caption', '.letter.bottom', 'text.scale', 'path.scale.rim'];
                    const all = kinds.map((kind) => {
                        const { left, top, right, bottom } = element
                            .querySelector(kind)!
                            .getBoundingClientRect();
                        return { kind, left, top, right, bottom };
                    });
                    return all.flatMap((a, n) =>
                        all
                            .slice(n + 1)
                            // Bar and label are one mark.
                            .filter((b) => !(a.kind.includes('scale') && b.kind.includes('scale')))
                            .filter((b) => a.left < b.right && b.left < a.right)
                            .filter((b) => a.top < b.bottom && b.top < a.bottom)
                            .map((b) => `${a.kind} and ${b.kind}`),
                    );
                }, view);
                assert.deepEqual(found, [], `${width} × ${height}, slab ${slab}: ${view}`);
            }
        }
});

test('the legend covers little of a view, and no caption', async () => {
    await page.evaluate(() => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({ overlay: { kind: 'jacobian' }, sections: { slab: 0 } });
    });
    for (const [width, height] of kWindows) {
        await resize(width, height);
        await picture(page, `small_views_${width}`);
        const { share, covered, cut } = await page.evaluate(() => {
            const legend = document.querySelector<HTMLElement>('.legend')!;
            const box = legend.getBoundingClientRect();
            const over = [...document.querySelectorAll('.view')]
                .map((view) => view.getBoundingClientRect())
                .find(
                    (view) =>
                        box.left >= view.left &&
                        box.top >= view.top &&
                        box.right <= view.right &&
                        box.bottom <= view.bottom,
                );
            const captions = [...document.querySelectorAll('.caption')].filter((caption) => {
                const { left, top, right, bottom } = caption.getBoundingClientRect();
                return left < box.right && box.left < right && top < box.bottom && box.top < bottom;
            });
            return {
                share: over ? (box.width * box.height) / (over.width * over.height) : Infinity,
                covered: captions.map((caption) => caption.textContent),
                cut: [legend.scrollWidth, legend.clientWidth, legend.innerText],
            };
        });
        const what = `${width} × ${height}`;
        assert.ok(share < 0.08, `${what}: ${share} of a view`);
        assert.deepEqual(covered, [], what);
        assert.ok(cut[0]! <= cut[1]!, `${what}: ${cut.join(' ')}`);
    }
});
