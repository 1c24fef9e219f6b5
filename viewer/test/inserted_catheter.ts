// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Catheter without a simulation: a curve through the lumen of an aorta, for pictures.

import type { Page } from 'playwright-core';
import type { Vec3 } from '../src/maths/vec.ts';
import type { Session } from '../src/tools/session.ts';

/// Curve from the abdomen to the arch of aorta_cta_1p5mm, by `pliant path` [mm, LPS].
export const kAortaLumen: readonly Vec3[] = [
    [-3, -149, 545],
    [-1.3, -148.5, 566],
    [-0.4, -145.6, 587],
    [7.1, -140.3, 607],
    [14.9, -131.1, 626],
    [21.2, -121.2, 645],
    [23.4, -113.5, 664],
    [22.8, -112.5, 686],
    [19.9, -116.6, 708],
    [19.3, -124.8, 728],
    [19.1, -140.1, 743],
];
const kRadius = 0.8; // [mm]

/// Makes the page show a vessel with this catheter; without points: none.
export const insertCatheter = (page: Page, catheter: readonly Vec3[]): Promise<void> =>
    page.evaluate(
        ({ catheter, radius }) => {
            const { store, stage } = (window as never as { pliant: Session }).pliant;
            const rest = new Float32Array();
            const wall = { rest, places: rest, moved: rest, corners: new Uint32Array() };
            stage.vessel = { ...wall, catheter, radius } as never;
            const { shared, versions } = store.state;
            const numbers = { inserted_mm: 0, force_n: 0, wall_moved_mm: 0, depth_mm: 0 };
            const vessel = { ...numbers, sub_steps: 0, pace: 0, warnings: [] };
            store.set({
                shared: { ...shared!, vessel: catheter.length ? vessel : undefined } as never,
                versions: { vessel: versions.vessel + 1 },
            });
        },
        { catheter, radius: kRadius },
    );
