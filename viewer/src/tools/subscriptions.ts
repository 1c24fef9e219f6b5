// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Subscriptions to data beside the voxels: an overlay, the rest field while the style or marks need
// it, a vessel with its catheter. Fields are at rest until their boxes arrive.

import type { BoxFrame, OverlayKind } from '../net/protocol.ts';
import { type SurfaceFrame, Vessel, type VesselFrame } from '../net/vessel.ts';
import { kKinds } from '../state/overlay_kinds.ts';
import { offersVessel } from '../state/state.ts';
import { kOutsideField } from '../views/orbit.ts';
import { OverlayField } from '../views/overlay_field.ts';
import { RestField } from '../views/rest_field.ts';
import { keptInside } from '../views/section_geometry.ts';
import { behindTip, outsideOf } from '../views/vessel_camera.ts';
import type { Scene } from './scene.ts';

export class Subscriptions {
    private askedOverlay: OverlayKind = 'none';
    private askedRest = false;
    private vesselIsNew = false; // not shown yet

    constructor(private readonly scene: Scene) {
        scene.store.listen((state, before) => {
            if (state.overlay !== before.overlay) this.askOverlay();
            const { look, marks, tool, link, shared } = state;
            // A catheter of another tissue or scan, later than the welcome.
            const isNew = offersVessel(shared) && !offersVessel(before.shared);
            if (isNew && link === before.link) this.askVessel();
            if (look !== before.look || marks !== before.marks || tool !== before.tool)
                this.askRest();
        });
    }

    /// Renews the subscriptions to fields, which end with the connection and with the scan.
    askAgain(): void {
        this.askOverlay();
        this.askRest();
    }

    /// Subscribes to the vessel, if there is one. The subscription ends with the connection.
    askVessel(): void {
        const { link, shared } = this.scene.store.state;
        if (link.features.includes('vessel') && offersVessel(shared))
            void this.scene.connection.ask({ do: 'vessel', on: true });
    }

    /// Forgets the subscriptions to fields.
    forgetFields(): void {
        this.askedOverlay = 'none';
        this.askedRest = false;
    }

    forgetVessel(): void {
        this.setVessel(undefined);
        this.vesselIsNew = false;
        this.scene.store.set({ versions: { vessel: 0 } });
    }

    /// Sets whether the camera moves to the vessel when it and the voxels have arrived.
    expectVessel(expected: boolean): void {
        this.vesselIsNew = expected;
    }

    overlayBox(frame: BoxFrame): void {
        const { stage, store } = this.scene;
        const { overlay } = stage;
        // A box of an overlay that was given up may still arrive.
        if (!overlay || kKinds[overlay.kind].format !== frame.format) return;
        overlay.patch(frame.box, frame.halves);
        if (!frame.last) return;
        const version = store.state.scan.overlay + 1;
        store.set({ scan: { overlay: version, extreme: overlay.extreme } });
    }

    restBox(frame: BoxFrame): void {
        const { rest } = this.scene.stage;
        if (!rest) return; // of a field that was given up
        rest.patch(frame.box, frame.halves);
        if (frame.last) this.countRest();
    }

    vesselFrame(frame: SurfaceFrame | VesselFrame): void {
        const { store, vessel } = this.scene;
        if (frame.kind === 'surface') this.setVessel(new Vessel(frame.rest, frame.corners));
        else {
            vessel?.take(frame);
            this.followTip();
        }
        store.set({ versions: { vessel: store.state.versions.vessel + 1 } });
        this.openVessel();
    }

    /// Moves the crosshair to the tip of a catheter that this client drives.
    private followTip(): void {
        const { vessel, volume, store } = this.scene;
        const { tool, shared } = store.state;
        const tip = vessel?.catheter[vessel.catheter.length - 1];
        const moves = !!(shared?.vessel?.insert_mm_s || shared?.vessel?.rotate_deg_s);
        if (!tip || !volume || !tool.follow || tool.name !== 'catheter' || !moves) return;
        store.set({ sections: { cursor: keptInside(volume.grid, tip) } });
    }

    /// Moves the camera to a new vessel, if it and the voxels have arrived.
    openVessel(): void {
        const { vessel, volume, store, surface } = this.scene;
        if (!this.vesselIsNew || !volume || !vessel?.catheter.length) return;
        if (store.state.scan.loaded < 1) return;
        this.vesselIsNew = false;
        const orbit = outsideOf(vessel, Math.tan((kOutsideField * Math.PI) / 360));
        const camera = behindTip(vessel, volume, surface) ?? store.state.view.camera;
        const cursor = vessel.catheter[vessel.catheter.length - 1]!;
        store.set({ view: { camera, orbit, outside: true }, sections: { cursor } });
    }

    private setVessel(vessel: Vessel | undefined): void {
        this.scene.vessel = vessel;
        this.scene.stage.vessel = vessel;
    }

    private askOverlay(): void {
        const { store, connection, stage } = this.scene;
        const { kind } = store.state.overlay;
        const { features, status } = store.state.link;
        if (kind === this.askedOverlay || status !== 'open') return;
        if (!features.includes('overlay')) {
            if (kind !== 'none') store.set({ overlay: { kind: 'none' } });
            return;
        }
        this.askedOverlay = kind;
        void connection.ask({ do: 'overlay', kind }, (answer) => {
            const { volume } = this.scene;
            if (answer?.t === 'error') store.set({ overlay: { kind: 'none' } });
            if (answer?.t !== 'done' || this.askedOverlay !== kind) return;
            stage.setOverlay(
                kind === 'none' || !volume ? undefined : new OverlayField(kind, volume.grid),
            );
            store.set({ scan: { overlay: store.state.scan.overlay + 1, extreme: 0 } });
        });
    }

    private askRest(): void {
        const { store, connection, stage } = this.scene;
        const { look, link, marks, tool } = store.state;
        const marked = marks.list.length > 0 || tool.name === 'measure';
        const on = (look.style === 'real' || marked) && link.features.includes('rest');
        if (!on) stage.setRest(undefined);
        if (on === this.askedRest || link.status !== 'open') return;
        this.askedRest = on;
        void connection.ask({ do: 'rest', on }, (answer) => {
            // If the server has no memory for the field, patterns don't move with the tissue.
            if (answer?.t !== 'done' || this.askedRest !== on) return;
            const { volume } = this.scene;
            stage.setRest(on && volume ? new RestField(volume.grid) : undefined);
            this.countRest();
        });
    }

    private countRest(): void {
        const { store } = this.scene;
        store.set({ versions: { rest: store.state.versions.rest + 1 } });
    }
}
