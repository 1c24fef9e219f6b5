// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Instruments in the sections: shafts are outlined, at least three pixels wide, with a dot where
// they cross the slice. Positions are computed from the crosshair and the scale alone.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { along, dot, norm, normalized, sub, type Vec3 } from '../src/maths/vec.ts';
import type { SectionName } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import { dragBy, picture, rectOf, spot, stateOf, still } from './browser.ts';
import { page, useOnePage } from './one_page.ts';

useOnePage();

// Right, up and across of each section's picture [LPS].
const kAxes: Record<SectionName, [Vec3, Vec3, Vec3]> = {
    axial: [
        [1, 0, 0],
        [0, -1, 0],
        [0, 0, 1],
    ],
    coronal: [
        [1, 0, 0],
        [0, 0, 1],
        [0, 1, 0],
    ],
    sagittal: [
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 0],
    ],
};

interface Mark {
    kind: string;
    width: number;
    points: [number, number][];
}

const marksIn = (view: SectionName): Promise<Mark[]> =>
    page.locator(`.view.${view} svg > :is(polyline, polygon, circle)`).evaluateAll((all) =>
        all.map((mark) => {
            const number = (name: string): number => Number(mark.getAttribute(name));
            const text = mark.getAttribute('points');
            return {
                kind: mark.getAttribute('class')!,
                width: parseFloat(getComputedStyle(mark).strokeWidth),
                points: (text
                    ? text.split(' ').map((p) => p.split(',').map(Number))
                    : [[number('cx'), number('cy')]]) as [number, number][],
            };
        }),
    );

test('a shaft is outlined in the sections', async () => {
    const start = await stateOf(page);
    await page.keyboard.press('3');
    // So that the held tool stays where it is.
    const { strength } = start.tool;
    const setStrength = (value: number): Promise<void> =>
        page.evaluate((v) => {
            (window as never as { pliant: Session }).pliant.store.set({
                // Sections that follow the tool would leave the slices chosen here.
                tool: { strength: v, follow: v > 0 },
            });
        }, value);
    await setStrength(0);
    const [x, y] = await spot(page, 'endoscope', 0.6, 0.4);
    await page.mouse.move(x, y);
    await page.mouse.down(); // the tool is shown before it acts
    const { balls, grid } = await page.evaluate(() => {
        const { stage, volume } = (window as never as { pliant: Session }).pliant;
        return { balls: stage.balls, grid: volume!.grid };
    });
    assert.equal(balls.length, 1);
    const { centre, radius, kind } = balls[0]!;
    assert.equal(kind, 'ball');
    // From the working channel, below right of the lens, to the centre of the ball.
    const { camera } = start.view;
    const ahead = normalized(camera.look);
    const up = normalized(along(camera.up, -dot(camera.up, ahead), ahead));
    const right: Vec3 = [
        ahead[1] * up[2] - ahead[2] * up[1],
        ahead[2] * up[0] - ahead[0] * up[2],
        ahead[0] * up[1] - ahead[1] * up[0],
    ];
    const share = Math.min(1, radius / 2);
    const base = along(along(along(camera.eye, 3.2 * share, right), -3 * share, up), -share, ahead);
    await still(page);
    let dots = 0;
    // The slice cuts the middle of the shaft, then lies beside it.
    for (const through of [true, false])
        for (const view of ['axial', 'coronal', 'sagittal'] as const) {
            const [u, v, across] = kAxes[view];
            const middle = along(base, 0.5, sub(centre, base));
            const away = 2 * radius + Math.abs(dot(sub(centre, base), across));
            const side = dot(middle, across) > 0 ? -1 : 1; // towards the middle of the scan
            const cursor = through ? middle : along(middle, side * away, across);
            await page.evaluate((c) => {
                (window as never as { pliant: Session }).pliant.store.set({
                    sections: { cursor: c },
                });
            }, cursor);
            await page.waitForTimeout(150);
            const box = await rectOf(page, view);
            const extent = grid.size.map((n, a) => n * grid.spacing[a]!) as never as Vec3;
            const size = (axis: Vec3): number => Math.abs(dot(extent, axis));
            const scale = Math.max(size(u) / box.width, size(v) / box.height);
            const marks = await marksIn(view);
            const rims = marks.filter((m) => m.kind.startsWith('rim'));
            const shafts = marks.filter((m) => m.kind.startsWith('shaft own'));
            assert.ok(shafts.length >= 1 && shafts.every((m) => m.width >= 3), view);
            const strong = shafts.filter((m) => m.kind.includes('near'));
            assert.equal(strong.length > 0, through, view);
            for (const m of strong) {
                const rim = rims.find((r) => String(r.points) === String(m.points));
                assert.ok(rim && rim.width >= m.width + 2, `${view}: an outline`);
            }
            // The whole shaft in pixels.
            const length = norm([dot(sub(centre, base), u), dot(sub(centre, base), v), 0]) / scale;
            const [from, to] = [shafts[0]!.points[0]!, shafts[0]!.points.at(-1)!];
            assert.ok(Math.abs(Math.hypot(to[0] - from[0], to[1] - from[1]) - length) < 0.1);
            const pierced = marks.filter((m) => m.kind === 'pierced');
            assert.equal(pierced.length, through ? 1 : 0, view);
            if (!through) continue;
            ++dots;
            // Crosshair and dot are in the middle of the shaft.
            const crosshair = page.locator(`.view.${view} svg`);
            const cx = Number(await crosshair.locator('.along').first().getAttribute('x1'));
            const cy = Number(await crosshair.locator('.across').first().getAttribute('y1'));
            const [px, py] = pierced[0]!.points[0]!;
            assert.ok(
                Math.hypot(px - cx, py - cy) < 0.1,
                `${view}: ${px},${py} beside ${cx},${cy}`,
            );
            await picture(page, `shaft_${view}`);
        }
    assert.equal(dots, 3);
    await page.mouse.up();
    await setStrength(strength);
    await page.waitForTimeout(150);
    assert.equal((await marksIn('axial')).filter((m) => m.kind.startsWith('shaft')).length, 0);
    // A click with a tool pushes nothing.
    assert.equal((await stateOf(page)).shared!.undo.steps, 0);
});

test('the head is in the sections while it pushes', async () => {
    await page.keyboard.press('3');
    await dragBy(page, await spot(page, 'endoscope', 0.6, 0.4), [4, 0]);
    await page.mouse.move(...(await spot(page, 'axial', 0.5, 0.45)));
    await page.mouse.down();
    await page.mouse.move(...(await spot(page, 'axial', 0.52, 0.45)), { steps: 5 });
    await page.waitForTimeout(300);
    const marks = await marksIn('axial');
    const head = marks.find((m) => m.kind === 'head own near')!;
    assert.ok(head.width >= 3);
    const rim = marks.find(
        (m) => m.kind === 'rim near' && String(m.points) === String(head.points),
    );
    assert.ok(rim && rim.width >= head.width + 2);
    await page.mouse.up();
});
