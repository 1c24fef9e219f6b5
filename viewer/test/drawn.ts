// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pictures of the endoscope, drawn by the page's own view into a corner of its canvas and read
// back, with any state, tools and catheter.

import type { Page } from 'playwright-core';
import type { Vec3 } from '../src/maths/vec.ts';
import type { Patch } from '../src/state/store.ts';
import type { Session } from '../src/tools/session.ts';
import type { EndoscopeView } from '../src/views/endoscope_view.ts';
import type { ToolBall } from '../src/views/instruments.ts';

export interface Wanted {
    readonly width: number;
    readonly height: number;
    readonly state: Patch;
    readonly iso?: number; ///< [HU]; 30000: no wall
    readonly balls?: readonly ToolBall[];
    readonly catheter?: readonly Vec3[];
    readonly radius?: number; ///< of the catheter [mm]
    readonly moving?: boolean; ///< a coarser picture, as during motion
}

/// Draws a picture. @returns red, green, blue of each pixel, row by row from the upper left corner
export async function drawn(page: Page, wanted: Wanted): Promise<Uint8Array> {
    const text = await page.evaluate((w) => {
        const { stage, store } = (window as never as { pliant: Session }).pliant;
        const { renderer } = stage;
        const { endoscope: view } = stage as never as { endoscope: EndoscopeView };
        const { shared } = store.state;
        const iso_hu = w.iso ?? shared!.iso_hu;
        const groups = Object.entries(w.state).map(([name, values]) => [
            name,
            { ...store.state[name as 'view'], ...(values as object) },
        ]);
        const state = {
            ...store.state,
            ...Object.fromEntries(groups),
            shared: { ...shared, iso_hu, vessel: w.catheter ? {} : shared!.vessel },
        };
        const vessel = w.catheter && {
            rest: new Float32Array(9),
            corners: new Uint32Array([0, 1, 2]),
            places: new Float32Array(9),
            moved: new Float32Array(3),
            catheter: w.catheter,
            radius: w.radius ?? 0.8,
        };
        const counter = window as never as { drawnVessels?: number };
        counter.drawnVessels = (counter.drawnVessels ?? 1e6) + 1;
        view.setVessel(vessel as never, counter.drawnVessels);
        const rect = { x: 0, y: 0, width: w.width, height: w.height };
        view.draw(renderer, state as never, w.balls ?? [], rect, 1, { moving: w.moving });
        const gl = renderer.getContext() as WebGL2RenderingContext;
        const data = new Uint8Array(4 * w.width * w.height);
        gl.readPixels(0, 0, w.width, w.height, gl.RGBA, gl.UNSIGNED_BYTE, data);
        view.setVessel(undefined, -2);
        stage.invalidate();
        let rows = ''; // as text: long lists of numbers take seconds
        for (let y = w.height - 1; y >= 0; --y)
            for (let x = 0; x < w.width; ++x) {
                const at = 4 * (y * w.width + x);
                rows += String.fromCharCode(data[at]!, data[at + 1]!, data[at + 2]!);
            }
        return btoa(rows);
    }, wanted);
    return Uint8Array.from(Buffer.from(text, 'base64'));
}

/// Mask of the pixels that differ between two pictures.
export const different = (a: Uint8Array, b: Uint8Array): boolean[] =>
    Array.from({ length: a.length / 3 }, (_, i) =>
        [0, 1, 2].some((c) => a[3 * i + c] !== b[3 * i + c]),
    );

/// Positions where two masks differ although the expected one is constant in the 3 × 3
/// neighbourhood; single pixels may be hairline gaps, and do not count.
export function misses(
    found: readonly boolean[],
    expected: readonly boolean[],
    width: number,
): string[] {
    const around = [-1, 0, 1].flatMap((dy) => [-1, 0, 1].map((dx) => dy * width + dx));
    const missed = new Set<number>();
    for (let i = width + 1; i < expected.length - width - 1; ++i) {
        if (i % width === 0 || i % width === width - 1) continue;
        if (found[i] === expected[i]) continue;
        if (around.every((step) => expected[i + step] === expected[i])) missed.add(i);
    }
    return [...missed]
        .filter((i) => around.some((step) => step !== 0 && missed.has(i + step)))
        .map((i) => `${i % width},${Math.floor(i / width)} ${expected[i]}`);
}
