// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The own tool in the scene: shown before a stroke, moved by it, drawn, and reported to the server.

import { normalized, type Vec3 } from '../maths/vec.ts';
import type { Tool } from '../net/protocol.ts';
import { scaleOf } from '../state/units.ts';
import { kBladeRadius, kHeads, type ToolBall, type ToolKind } from '../views/instruments.ts';
import { keptInside } from '../views/section_geometry.ts';
import type { Haptics } from './haptics.ts';
import type { Scene } from './scene.ts';
import type { Stroke } from './strokes.ts';

const kPoseMs = 50; // between two poses that are sent

export class Hand {
    stroke: Stroke | undefined;
    private poised: { place: Vec3; kind: ToolKind; radius: number } | undefined;
    private followed: Vec3 | undefined;
    private lastPose = 0;
    private poseText = '';

    constructor(
        private readonly scene: Scene,
        private readonly device: Haptics,
    ) {}

    /// Shows the chosen tool at a position before it acts; undefined: takes it away.
    poise(place: Vec3 | undefined): void {
        const { name, radius } = this.scene.store.state.tool;
        const kind = kHeads[name];
        this.poised = place && kind && { place, kind, radius };
        this.placeBalls();
    }

    begin(stroke: Stroke): void {
        this.stroke = stroke;
        this.poised = undefined;
        this.placeBalls();
    }

    drag(place: Vec3): void {
        this.stroke?.to(place);
        this.placeBalls();
    }

    async end(): Promise<void> {
        const stroke = this.stroke;
        this.stroke = undefined;
        await stroke?.end();
        this.placeBalls();
    }

    /// Forgets the stroke without ending it: the connection or the scan is gone.
    forget(): void {
        this.stroke = undefined;
    }

    /// Draws the tools of all clients.
    placeBalls(): void {
        const balls: ToolBall[] = this.scene.store.state.hands.others
            .filter((tool) => tool.radius > 0 && !this.isEye(tool))
            .map((tool) => ({
                centre: tool.position,
                radius: tool.radius,
                own: false,
                kind: tool.kind === 'endoscope' ? ('scope' as const) : ('ball' as const),
                direction: normalized(tool.direction),
            }));
        const { stroke, poised } = this;
        const held = stroke ?? poised;
        const centre = stroke ? stroke.path[stroke.path.length - 1] : poised?.place;
        const scale = scaleOf(this.scene.store.state.scan.volume);
        const radius = held?.kind === 'blade' ? scale * kBladeRadius : (held?.radius ?? 0);
        if (held && centre && radius > 0)
            balls.unshift({ centre, radius, own: true, kind: held.kind, closed: !!stroke?.closed });
        this.scene.stage.setTools(balls);
    }

    /// Moves the crosshair to the tool while it is at work, so that the sections show it.
    follow(): void {
        const { volume, store } = this.scene;
        const { path } = this.stroke ?? {};
        const place = path?.[path.length - 1] ?? this.poised?.place;
        if (!place || !volume || !store.state.tool.follow || place === this.followed) return;
        this.followed = place;
        store.set({ sections: { cursor: keptInside(volume.grid, place) } });
    }

    /// Sends the pose of the tool or of the endoscope after changes, at most every kPoseMs.
    /// @param eyeRadius  of the endoscope as an obstacle of tissue; 0: it is none
    sendPose(now: number, eyeRadius: number): void {
        const { connection, volume, store } = this.scene;
        if (now - this.lastPose <= kPoseMs || !connection.isOpen || !volume) return;
        const { view } = store.state;
        const at = this.stroke?.path[this.stroke.path.length - 1];
        const pose = {
            do: 'tool' as const,
            kind: at ? ('sphere' as const) : ('endoscope' as const),
            position: at ?? view.camera.eye,
            direction: view.camera.look,
            up: view.camera.up,
            radius: at ? this.stroke!.radius : eyeRadius,
        };
        const text = JSON.stringify(pose);
        if (text === this.poseText) return;
        this.poseText = text;
        this.lastPose = now;
        connection.tell(pose);
    }

    /// Tests whether a tool is this endoscope itself, held by a device.
    private isEye(tool: Tool): boolean {
        const { device } = this;
        return device.follows && device.isOwn && tool.client === device.news?.tool;
    }
}
