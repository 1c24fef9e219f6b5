// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Device with force feedback, used by this client or another: its state from the server, the last
// seconds of its force, and the poses of a device that is simulated by the browser (mouse, game
// pad, SpaceMouse). The server computes the force at 1 kHz.

import { flown } from '../maths/flight.ts';
import { firstHit, frameOf, type Surface } from '../maths/rays.ts';
import { add, along, mul, norm, sub, type Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';
import type { HapticsNews } from '../net/protocol.ts';
import type { View } from '../state/state.ts';
import { orbitCamera } from '../views/orbit.ts';
import { keptInside } from '../views/section_geometry.ts';
import { buttonsOff, kNoMotion, type Motion, moved, padMotion, spaceMouse } from './pads.ts';
import type { Scene } from './scene.ts';

export const kPlotSeconds = 10;
const kAhead = 10; // distance of the tool's start ahead of the tip, if there is room [mm]
const kBefore = 5; // the same from outside, to the surface [mm]
const kLens = 1.2;
const kOffWall = 0.5; // distance of the tool's start to the wall [mm]
const kShowMs = 80; // between two updates of the shown numbers
const kLead = 0.1; // motion of the mouse [mm per pixel]
const kLeadRoll = 0.5; // rotation of a catheter by the mouse [degrees per pixel]
const kPadRoll = 4.5; // rotation by a stick, per sideways motion [degrees/mm]

export interface Felt {
    readonly at: number; ///< time [ms]
    readonly newtons: number;
}

/// Start of the tool: ahead of the tip, and beside the middle of the view as far as the lumen has
/// room, like an instrument from the working channel. Where a wall is ahead: straight before it.
export function startOfTool(volume: VolumeData, view: View, tip: number, surface: Surface): Vec3 {
    const { camera, fieldOfView } = view;
    const { right, up, forward } = frameOf(camera);
    const ahead = mul(kAhead, forward);
    const place = flown(volume, camera.eye, ahead, tip, surface);
    if (norm(sub(place, add(camera.eye, ahead))) > 1e-6) return place;
    // Clear of the middle third of the picture's height, by the tool's radius. The lens draws both
    // nearer to the middle.
    const off = kLens * ((kAhead * Math.tan((fieldOfView * Math.PI) / 360)) / 3 + tip);
    return flown(volume, place, mul(off, sub(right, up)), tip + kOffWall, surface);
}

/// Start of the tool in the view from outside: in the middle of the picture, before the surface.
export function startFromOutside(
    volume: VolumeData,
    view: View,
    radius: number,
    surface: Surface,
): Vec3 {
    const { eye, look } = orbitCamera(view);
    const hit = firstHit(volume, eye, look, surface);
    return along(hit?.point ?? view.orbit.centre, -(radius + kBefore), look);
}

export class Haptics {
    /// Forces of the last seconds, oldest first.
    readonly felt: Felt[] = [];
    scale = 1;
    device = '';
    follows = false; ///< the endoscope moves with the tool
    private fromOutside = false; ///< its frame is that of the view from outside
    private place: Vec3 = [0, 0, 0]; // of a device in the browser, in its own frame [mm]
    private roll = 0; // [degrees]
    private newest: HapticsNews | null = null; // not shown yet
    private shownAt = 0;
    private puck: (() => Motion) | undefined;

    constructor(private readonly scene: Scene) {}

    get news(): HapticsNews | null {
        return this.scene.store.state.device.news;
    }
    /// Tests whether this client uses the device.
    get isOwn(): boolean {
        return this.news?.on === true && this.news.client === this.scene.connection.client;
    }
    /// Tests whether the mouse in the endoscope's view moves it.
    get isLed(): boolean {
        return this.isOwn && this.news!.device === 'browser';
    }
    /// Tests the same, with the view as it is now: it moves as seen where it was started.
    get isLedHere(): boolean {
        const { outside } = this.scene.store.state.view;
        return this.isLed && outside === (this.fromOutside && !this.news!.holds);
    }

    take(news: HapticsNews, now: number): void {
        const before = this.newest ?? this.news;
        if (before && !news.on && news.why) this.scene.say(`device: ${news.why}`);
        this.newest = news;
        const same = (['on', 'tool', 'stopped', 'lost'] as const).every(
            (key) => news[key] === before?.[key],
        );
        if (!same || now - this.shownAt > kShowMs) this.show(now);
        if (!news.on) return;
        if (before?.tool !== news.tool) this.felt.length = 0;
        this.felt.push({ at: now, newtons: news.largest_n! });
        while (this.felt[0]!.at < now - 1000 * kPlotSeconds) this.felt.shift();
        if (this.follows && this.isOwn && !news.holds) {
            const { camera } = this.scene.store.state.view;
            this.scene.store.set({ view: { camera: { ...camera, eye: news.proxy_mm! } } });
        }
    }

    /// Shows the newest message; they come up to 60 times a second, too often to be read.
    private show(now: number): void {
        if (!this.newest) return;
        this.scene.store.set({ device: { news: this.newest.on ? this.newest : null } });
        const { volume, store } = this.scene;
        const { holds, proxy_mm: place } = this.newest;
        if (place && !holds && this.isOwn && volume && store.state.tool.follow)
            store.set({ sections: { cursor: keptInside(volume.grid, place) } });
        this.newest = null;
        this.shownAt = now;
    }
    /// Forgets the state of the device, after a loss of the connection.
    forget(): void {
        this.newest = null;
        this.scene.store.set({ device: { news: null } });
    }

    /// Starts the device at the endoscope's tip, or ahead of it; from outside before the surface in
    /// the middle of the picture, with the radius of the tools. @returns whether it has started
    async start(): Promise<boolean> {
        const { volume, surface } = this.scene;
        const { view, flight, device, shared, tool } = this.scene.store.state;
        if (!volume || !shared) return false;
        this.fromOutside = view.outside && !this.follows;
        const camera = this.fromOutside ? orbitCamera(view) : view.camera;
        const radius = Math.min(Math.max(this.fromOutside ? tool.radius : flight.tip, 0.5), 20);
        const position = this.follows
            ? camera.eye
            : this.fromOutside
              ? startFromOutside(volume, view, radius, surface)
              : startOfTool(volume, view, flight.tip, surface);
        this.place = [0, 0, 0];
        this.roll = 0;
        // Tissue that doesn't relax is felt only once.
        if (!shared.relaxing) await this.scene.ask({ do: 'relax', on: true });
        return this.scene.ask({
            do: 'haptics',
            wish: 'start',
            device: this.device || device.offered[0]!,
            position,
            look: camera.look,
            up: camera.up,
            scale: this.scale,
            radius,
        });
    }

    end(): void {
        void this.scene.ask({ do: 'haptics', wish: 'end' });
    }

    /// Stops all force at once; called again: resumes it.
    toggleStop(): void {
        if (!this.news) return;
        const wish = this.news.stopped && this.isOwn ? 'go' : 'stop';
        void this.scene.ask({ do: 'haptics', wish });
    }

    /// Moves the device by the mouse: right and down [pixels], ahead [mm]. A catheter is inserted
    /// by moving up and rotated by moving aside.
    lead(dx: number, dy: number, ahead = 0): void {
        if (this.news?.holds) {
            this.roll += kLeadRoll * dx;
            this.place = moved(this.place, [0, 0, kLead * dy - ahead], 1);
            return;
        }
        this.place = moved(this.place, [kLead * dx, -kLead * dy, -ahead], 1);
    }

    /// Lets the user choose a SpaceMouse. @pre called by a click, as browsers require
    async openSpaceMouse(): Promise<void> {
        try {
            this.puck = await spaceMouse();
            this.scene.say(this.puck ? 'SpaceMouse: ready' : 'SpaceMouse: none was chosen');
        } catch (error) {
            this.scene.say(`SpaceMouse: ${(error as Error).message}`);
        }
    }

    /// Updates the pose of a simulated device, once per frame.
    tick(seconds: number, now: number): void {
        if (now - this.shownAt > kShowMs) this.show(now);
        if (!this.isLed || document.hidden) return;
        const pads = navigator.getGamepads?.() ?? [];
        const pad = pads.find((p) => p && !buttonsOff(p)) ?? pads.find((p) => p);
        const motion = this.puck?.() ?? (pad ? padMotion(pad) : kNoMotion);
        if (this.news!.holds) this.roll += kPadRoll * motion[0] * seconds;
        this.place = moved(this.place, this.news!.holds ? [0, 0, motion[2]] : motion, seconds);
        const roll_deg = Math.round(100 * this.roll) / 100;
        this.scene.connection.tell({ do: 'haptic_pose', position: this.place, roll_deg });
    }
}
