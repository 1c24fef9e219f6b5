// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Sizes of the lumen: at the endoscope's tip while that is wanted, and along the path on request.
// They are measured in the page's mirror of the deformed scan, perpendicular to the view or to the
// path.

import { crossSection, sectionsAlong } from '../maths/lumen.ts';
import type { LumenAt } from '../state/state.ts';
import { scaleOf } from '../state/units.ts';
import type { Scene } from './scene.ts';

const kTipMs = 150; // between two measurements at the tip
const kTurnMs = 12; // of measurements along a path, per frame

export class LumenTool {
    private lastTip = 0;
    private measured: readonly unknown[] = []; // inputs of the tip's section
    private run: Generator<unknown> | undefined;

    constructor(private readonly scene: Scene) {
        scene.store.listen((state, before) => {
            // Another path has other sizes.
            if (state.way.path === before.way.path) return;
            this.run = undefined;
            scene.store.set({ lumen: { along: [], share: 1 } });
        });
    }

    /// Updates the measurements that are due. @param now  [ms]
    tick(now: number): void {
        this.measureTip(now);
        const end = performance.now() + kTurnMs;
        while (this.run && performance.now() < end) if (this.run.next().done) this.run = undefined;
    }

    private measureTip(now: number): void {
        const { store, volume, surface } = this.scene;
        const { lumen, view, scan } = store.state;
        if (!lumen.on) {
            if (lumen.tip) store.set({ lumen: { tip: null } });
            this.measured = [];
            return;
        }
        const { eye, look } = view.camera;
        const needs = [eye, look, scan.voxels, volume, surface.iso, surface.rising];
        if (!volume || scan.loaded < 1 || now - this.lastTip < kTipMs) return;
        if (needs.every((need, n) => need === this.measured[n])) return;
        this.lastTip = now;
        this.measured = needs;
        const scale = scaleOf(scan.volume);
        store.set({ lumen: { tip: crossSection(volume, eye, look, surface, scale) ?? null } });
    }

    /// Measures the lumen along the path, over several frames.
    measurePath(): void {
        this.run = this.alongPath();
    }

    private *alongPath(): Generator<unknown> {
        const { store, volume, surface } = this.scene;
        const { path } = store.state.way;
        if (!volume || !path) return;
        const along: LumenAt[] = [];
        const { step = 0 } = store.state.shared ?? {};
        const scale = scaleOf(store.state.scan.volume);
        store.set({ lumen: { along, step, share: 0 } });
        for (const section of sectionsAlong(volume, path.points, surface, scale)) {
            const way = path.wayOf(along.length);
            const size = !section || section === 'open' ? null : section;
            along.push({
                way,
                size: size && {
                    area: size.area,
                    equivalent: size.equivalent,
                    inscribed: size.inscribed,
                },
            });
            store.set({ lumen: { share: along.length / path.points.length } });
            yield;
        }
        store.set({ lumen: { along: [...along], share: 1 } });
    }
}
