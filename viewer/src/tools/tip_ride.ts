// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The endoscope rides on the catheter's tip (`view.onTip`): its camera approaches the one behind
// the tip exponentially, as the tip advances. Each other motion of the camera ends it.

import { hasVessel } from '../state/state.ts';
import { onTip } from '../views/vessel_camera.ts';
import { cameraBetween } from './follow.ts';
import type { Scene } from './scene.ts';

const kGlide = 0.08; // time constant of the approach [s]

export class TipRide {
    private isMoving = false; // the camera is changed here

    /// @param pause  ends other motions of the camera
    constructor(
        private readonly scene: Scene,
        private readonly pause: () => void,
    ) {
        scene.store.listen((state, before) => {
            const { view, scan } = state;
            const wasOn = view.onTip && before.view.onTip;
            const isOwn = view.camera !== before.view.camera && !this.isMoving;
            if (wasOn && isOwn && scan.loaded === 1) this.end();
        });
    }

    /// Begins a ride, seen from inside, or ends it.
    toggle(): void {
        const { store, history } = this.scene;
        const { view, display } = store.state;
        if (view.onTip) {
            history.step('ride', () => this.end());
            return;
        }
        if (!hasVessel(store.state)) {
            this.scene.warn('no catheter here: open the scene of a vessel with pliant serve');
            return;
        }
        this.pause();
        const isHidden = display.maximised && display.maximised !== 'endoscope';
        history.step('ride', () =>
            store.set({
                view: { onTip: true, outside: false, fluoroscopy: false, blended: false },
                ...(isHidden ? { display: { maximised: null } } : {}),
            }),
        );
        this.scene.say('the endoscope rides on the catheter’s tip');
    }

    /// Moves the camera with the tip. @returns whether the endoscope rides on it
    tick(seconds: number): boolean {
        const { store, vessel, volume, surface } = this.scene;
        const { view } = store.state;
        if (!view.onTip) return false;
        if (!vessel || !volume) return true; // not here yet
        if (!hasVessel(store.state)) {
            this.end();
            return false;
        }
        const target = onTip(vessel, volume, surface, view.camera);
        if (!target) return true; // no room: it waits
        const near = cameraBetween(view.camera, target, 1 - Math.exp(-seconds / kGlide));
        if (near === view.camera) return true;
        const camera = this.scene.isInTissue(near.eye) ? target : near;
        this.isMoving = true;
        store.set({ view: { camera } });
        this.isMoving = false;
        return true;
    }

    private end(): void {
        this.scene.store.set({ view: { onTip: false } });
        this.scene.say('the endoscope no longer rides on the tip');
    }
}
