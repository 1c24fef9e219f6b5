// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cameras of several clients: tells the own one, and follows that of another. Between the leader's
// messages the own camera approaches the newest one exponentially. Each own motion ends it.

import type { Camera } from '../maths/rays.ts';
import { add, along, mul, norm, normalized, sub, type Vec3 } from '../maths/vec.ts';
import type { CameraNews, OwnCamera } from '../net/company.ts';
import { nameOfClient } from '../state/company.ts';
import type { Scene } from './scene.ts';

const kTellMs = 50; // between two cameras that are sent
const kGlide = 0.08; // time constant of the approach [s]
const kGraceMs = 1500; // a leader may be away so long: it reconnects
const kAskMs = 1000; // between two requests to follow
const kArrived = 1e-4; // distance of cameras that count as equal [mm], and of unit vectors
const kNone: OwnCamera = { do: 'camera' };

/// Camera between two others; the first if they are equal, so that two clients that follow each
/// other come to rest. @param share  of the second, 0…1
export function cameraBetween(from: Camera, to: Camera, share: number): Camera {
    const near = (a: Vec3, b: Vec3): boolean => norm(sub(a, b)) < kArrived;
    if (near(from.eye, to.eye) && near(from.look, to.look) && near(from.up, to.up)) return from;
    const turned = (a: Vec3, b: Vec3): Vec3 => {
        const sum = add(mul(1 - share, a), mul(share, b));
        return norm(sum) > 0.1 ? normalized(sum) : b; // opposite directions have no middle
    };
    return {
        eye: along(from.eye, share, sub(to.eye, from.eye)),
        look: turned(from.look, to.look),
        up: turned(from.up, to.up),
    };
}

export class Follow {
    private target: Camera | undefined;
    private name = '';
    private isMoving = false; // the camera is changed here
    private askedAt = -Infinity;
    private awaySince: number | undefined;
    private told = JSON.stringify(kNone);
    private toldAt = -Infinity;

    /// @param pause  ends other motions of the camera
    constructor(
        private readonly scene: Scene,
        private readonly pause: () => void,
    ) {
        scene.store.listen((state, before) => {
            const isOwn = state.view.camera !== before.view.camera && !this.isMoving;
            if (state.company.leader && isOwn && state.scan.loaded === 1) this.end();
        });
    }

    /// Follows a client.
    begin(client: number): void {
        const { store } = this.scene;
        this.pause();
        this.target = undefined;
        this.awaySince = undefined;
        this.name = nameOfClient(store.state.shared, client);
        store.set({ company: { leader: client } });
        this.ask(performance.now());
    }

    /// Stays where the camera is. @param why  a line for the user
    end(why = `you no longer follow ${this.name}`): void {
        const { store, connection } = this.scene;
        if (!store.state.company.leader) return;
        this.target = undefined;
        store.set({ company: { leader: 0 } });
        void connection.ask({ do: 'follow', client: 0 });
        this.scene.say(why);
    }

    take({ client, eye, look, up }: CameraNews): void {
        if (client !== this.scene.store.state.company.leader) return;
        this.target = eye && look && up ? { eye, look, up } : undefined;
    }

    /// Tells and asks again: the server forgets both with the connection, cameras with the scan.
    renew(): void {
        this.told = JSON.stringify(kNone);
        this.askedAt = -Infinity;
        this.target = undefined;
    }

    /// Moves the camera with the leader's. @returns whether one is followed
    tick(seconds: number, now: number): boolean {
        const { state } = this.scene.store;
        const { leader } = state.company;
        if (!leader) return false;
        if (state.link.status !== 'open' || !state.shared) return true;
        if (!state.shared.clients.some((c) => c.client === leader)) {
            this.awaySince ??= now;
            this.target = undefined;
            this.askedAt = -Infinity;
            if (now - this.awaySince > kGraceMs)
                this.end(`${this.name} has left: you no longer follow`);
            return true;
        }
        this.awaySince = undefined;
        this.name = nameOfClient(state.shared, leader);
        if (this.target) this.moveTo(this.target, seconds);
        else if (now - this.askedAt > kAskMs) this.ask(now);
        return true;
    }

    /// Tells the own camera after changes.
    tell(now: number): void {
        const { store, connection, volume } = this.scene;
        const { link, scan, view } = store.state;
        if (!link.features.includes('follow') || !connection.isOpen) return;
        if (now - this.toldAt <= kTellMs) return;
        const { eye, look, up } = view.camera;
        const camera: OwnCamera =
            volume && scan.loaded === 1 ? { do: 'camera', eye, look, up } : kNone;
        const text = JSON.stringify(camera);
        if (text === this.told) return;
        this.told = text;
        this.toldAt = now;
        connection.tell(camera);
    }

    private ask(now: number): void {
        this.askedAt = now;
        const { leader } = this.scene.store.state.company;
        void this.scene.connection.ask({ do: 'follow', client: leader });
    }

    private moveTo(target: Camera, seconds: number): void {
        const { store } = this.scene;
        const before = store.state.view.camera;
        const camera = cameraBetween(before, target, 1 - Math.exp(-seconds / kGlide));
        if (camera === before) return;
        this.isMoving = true;
        store.set({ view: { camera }, sections: { cursor: camera.eye } });
        this.isMoving = false;
    }
}
