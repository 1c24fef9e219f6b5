// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The page's middle: takes what the server sends into the store, the mirror and the stage, flies
// the endoscope, starts and ends strokes, and tells the server where this client's tool is.

import { clearance, flown, freePlace, speedFor, wouldTouch } from '../maths/flight.ts';
import { voxelCount, voxelFromWorld, worldFromVoxel } from '../maths/grid.ts';
import { checksumOf } from '../maths/murmur.ts';
import type { Path } from '../maths/path.ts';
import { frameOf, inTissue, naturalUp } from '../maths/rays.ts';
import { add, along, mul, norm, normalized, sub, turned, type Vec3 } from '../maths/vec.ts';
import { VolumeData } from '../maths/volume.ts';
import { Connection, type Listener, type Memory } from '../net/connection.ts';
import { Latencies } from '../net/latencies.ts';
import {
    type BoxFrame,
    type Checksum,
    type Command,
    type Done,
    gridOf,
    type HapticsNews,
    type OverlayKind,
    type Refusal,
    type Role,
    type SharedState,
    type Tool,
    type VolumeInfo,
    type Welcome,
} from '../net/protocol.ts';
import { type SurfaceFrame, Vessel, type VesselFrame } from '../net/vessel.ts';
import { History } from '../state/history.ts';
import { keepView, takeUpView } from '../state/kept_view.ts';
import { kKinds } from '../state/overlay_kinds.ts';
import { initialState, pushOrSlide, type Store, surfaceOf } from '../state/store.ts';
import { kBladeRadius, kHeads, type ToolBall, type ToolKind } from '../views/instruments.ts';
import { kOutsideField } from '../views/orbit.ts';
import { OverlayField } from '../views/overlay_field.ts';
import { RestField } from '../views/rest_field.ts';
import { Stage } from '../views/stage.ts';
import { behindTip, outsideOf } from '../views/vessel_camera.ts';
import { Haptics } from './haptics.ts';
import { newStroke, note, type Stroke } from './strokes.ts';

const kPoseMs = 50; // between two poses that are sent
const kRoomReach = 60; // walls farther away don't matter for the speed [mm]
const kLongestFrame = 0.1; // a page that was asleep doesn't leap [s]
const kPathSpeed = 20; // [mm/s]
const kNewsMs = 2000; // longest wait for the state after an undo
const kEscape = 40; // an eye that tissue has closed over looks so far for a free place [mm]
const kTurnRate = 70; // of the keyboard [degrees/s]

/// What the keyboard asks for: along right, up and ahead, −1…1, and turns.
export interface Steering {
    move: Vec3;
    yaw: number;
    pitch: number;
    roll: number;
}

export class Session implements Listener {
    readonly connection: Connection;
    readonly history: History;
    readonly latencies = new Latencies();
    readonly device = new Haptics(this);
    stage!: Stage;
    volume: VolumeData | undefined;
    steering: () => Steering = () => ({ move: [0, 0, 0], yaw: 0, pitch: 0, roll: 0 });
    stroke: Stroke | undefined;
    private poised: { place: Vec3; kind: ToolKind; radius: number } | undefined;
    /// A line for screen readers, and for a moment for all others.
    say: (text: string) => void = () => {};
    onWelcome: () => void = () => {};
    /// Shows the movie's next picture. @returns whether one is playing
    playMovie: (seconds: number) => boolean = () => false;
    stopMovie: () => void = () => {};
    /// The hand on the catheter, each frame.
    drive: (seconds: number, now: number) => void = () => {};
    vessel: Vessel | undefined;
    private vesselIsNew = false; // nothing of it has been shown
    private received = 0; // voxels of the first snapshot
    private pushing = false; // a push of the tip is under way
    private tipStroke = 0;
    private flying = false;
    private lastPose = 0;
    private poseText = '';
    private boxesSinceDraw = 0;
    private eyeIsFree = false; // out of tissue when it was put there: it has to stay out
    private displaced: { from: Vec3; to: Vec3 } | undefined; // of an eye that tissue moved aside
    private askedOverlay: OverlayKind = 'none';
    private askedRest = false;
    private onState: () => void = () => {};

    constructor(
        readonly store: Store,
        url: string,
        hello: { role: Role; name: string },
        private readonly memory: Memory,
    ) {
        this.connection = new Connection(url, hello, this, memory);
        this.history = new History(store, (what) => this.step(what));
        store.listen((_, changed) => {
            if (changed.has('overlay')) this.askOverlay();
            if (changed.has('style')) this.askRest();
            if (changed.has('camera') || changed.has('wall')) this.eyeIsFree = !this.isInTissue();
        });
    }

    /// Sends a command, and shows what came of it.
    async ask(command: Command): Promise<boolean> {
        const answer = await this.connection.ask(command);
        note(this.store, answer);
        return answer?.t === 'done';
    }

    /// Undo or redo; done when the server has also said which steps are left.
    private async step(what: 'undo' | 'redo'): Promise<void> {
        const news = new Promise<void>((resolve) => {
            this.onState = resolve;
            setTimeout(resolve, kNewsMs);
        });
        if (await this.ask({ do: what })) await news;
    }

    // --- what the server sends

    welcome(message: Welcome): void {
        this.store.set({
            link: 'open',
            linkText: '',
            role: message.role,
            client: message.client,
            program: message.program,
            features: message.features,
            openBytes: message.open_bytes ?? 0,
            hapticDevices: message.haptic_devices ?? [],
            haptics: null,
            shared: message.state,
        });
        const held = this.volume && this.store.state.volume?.id === message.volume.id;
        if (this.volume && !held) this.forgetScan();
        this.askedOverlay = 'none'; // overlays end with the connection
        this.askedRest = false;
        if (!message.resumed || !held) this.takeVolume(message.volume, held === true);
        this.askOverlay();
        this.askRest();
        this.askVessel();
        this.onWelcome();
    }

    newVolume(info: VolumeInfo): void {
        this.forgetScan();
        this.askedOverlay = 'none'; // and with the scan
        this.askedRest = false;
        this.takeVolume(info, false);
        this.askOverlay();
        this.askRest();
    }

    /// Another scan takes the place of the one that is shown: nothing of it means anything there.
    private forgetScan(): void {
        keepView(this.store, this.memory);
        this.stroke = undefined;
        this.tipStroke = 0;
        this.history.clear();
        this.vessel = undefined;
        this.vesselIsNew = false;
        const { sections } = initialState();
        const nothing = { path: null, pathFlying: false, pathWay: 0, outcome: '', force: 0 };
        this.store.set({ ...nothing, sections, vessel: 0 });
        this.placeBalls();
    }

    state(shared: SharedState): void {
        const { iso, rising } = this.surface();
        this.store.set({ shared });
        const now = this.surface();
        // Another threshold doesn't move the eye, even if the eye is in tissue then.
        if (now.iso !== iso || now.rising !== rising) this.eyeIsFree = !this.isInTissue();
        this.onState();
    }

    box(frame: BoxFrame): void {
        const texture = this.stage.texture;
        if (!texture || !this.volume) return;
        texture.patch(frame.box, frame.halves);
        ++this.boxesSinceDraw;
        const { loaded } = this.store.state;
        if (loaded < 1) {
            this.received += frame.halves.length;
            const share = this.received / voxelCount(this.volume.grid);
            this.store.set({ loaded: frame.last ? 1 : Math.min(share, 0.99) });
        }
        if (frame.last) {
            this.latencies.arrived(frame.step);
            this.store.set({ voxels: this.store.state.voxels + 1 });
            this.openVessel();
            this.keepEyeFree();
        }
    }

    overlayBox(frame: BoxFrame): void {
        const { overlay } = this.stage;
        // One of an overlay that was given up may still come.
        if (!overlay || kKinds[overlay.kind].format !== frame.format) return;
        overlay.patch(frame.box, frame.halves);
        if (!frame.last) return;
        const { overlayVoxels } = this.store.state;
        this.store.set({ overlayVoxels: overlayVoxels + 1, overlayExtreme: overlay.extreme });
    }

    /// The server is asked for the overlay that is wanted; all is at rest until its boxes come.
    private askOverlay(): void {
        const { overlay: kind, features, link } = this.store.state;
        if (kind === this.askedOverlay || link !== 'open') return;
        if (!features.includes('overlay')) {
            if (kind !== 'none') this.store.set({ overlay: 'none' });
            return;
        }
        this.askedOverlay = kind;
        void this.connection.ask({ do: 'overlay', kind }, (answer) => {
            const { volume } = this;
            if (answer?.t === 'error') this.store.set({ overlay: 'none' });
            if (answer?.t !== 'done' || this.askedOverlay !== kind) return;
            this.stage.setOverlay(
                kind === 'none' || !volume ? undefined : new OverlayField(kind, volume.grid),
            );
            this.store.set({
                overlayVoxels: this.store.state.overlayVoxels + 1,
                overlayExtreme: 0,
            });
        });
    }

    restBox(frame: BoxFrame): void {
        const { rest } = this.stage;
        if (!rest) return; // one that was given up
        rest.patch(frame.box, frame.halves);
        if (frame.last) this.store.set({ restVersion: this.store.state.restVersion + 1 });
    }

    /// The rest field is asked for while the style needs it; all is at rest until its boxes come.
    private askRest(): void {
        const { style, features, link } = this.store.state;
        const on = style === 'real' && features.includes('rest');
        if (!on) this.stage.setRest(undefined);
        if (on === this.askedRest || link !== 'open') return;
        this.askedRest = on;
        void this.connection.ask({ do: 'rest', on }, (answer) => {
            // Where the server has no memory for it, patterns stay where they are.
            if (answer?.t !== 'done' || this.askedRest !== on) return;
            this.stage.setRest(on && this.volume ? new RestField(this.volume.grid) : undefined);
            this.store.set({ restVersion: this.store.state.restVersion + 1 });
        });
    }

    /// Those who ask are sent the vessel, where there is one; it ends with the connection.
    private askVessel(): void {
        const { features, shared } = this.store.state;
        if (features.includes('vessel') && shared?.tissue?.has_vessel)
            void this.connection.ask({ do: 'vessel', on: true });
    }

    vesselFrame(frame: SurfaceFrame | VesselFrame): void {
        if (frame.kind === 'surface') this.vessel = new Vessel(frame.rest, frame.corners);
        else this.vessel?.take(frame);
        this.store.set({ vessel: this.store.state.vessel + 1 });
        this.openVessel();
    }

    /// The first look at a scene with a catheter, once both it and the voxels are here.
    private openVessel(): void {
        const { vessel, volume } = this;
        if (!this.vesselIsNew || !volume || !vessel?.catheter.length) return;
        if (this.store.state.loaded < 1) return;
        this.vesselIsNew = false;
        const orbit = outsideOf(vessel, Math.tan((kOutsideField * Math.PI) / 360));
        const camera = behindTip(vessel, volume, this.surface()) ?? this.store.state.camera;
        const cursor = vessel.catheter[vessel.catheter.length - 1]!;
        this.store.set({ camera, cursor, orbit, outside: true });
    }

    tools(tools: Tool[]): void {
        const { client } = this.connection;
        const own = tools.find((tool) => tool.client === client);
        const others = tools.filter((tool) => tool.client !== client);
        this.store.set({ others, force: own ? norm(own.force) : 0 });
        this.placeBalls();
    }

    haptics(news: HapticsNews): void {
        this.device.take(news, performance.now());
    }

    refused(refusal: Refusal): void {
        if (refusal.code !== 'nothing') this.say(refusal.message);
    }

    lost(reason: string, retryMs?: number): void {
        this.stroke = undefined;
        const link = retryMs === undefined ? 'ended' : 'lost';
        this.store.set({ link, linkText: reason });
        this.device.forget();
    }

    done(answer: Done, sent: number): void {
        this.latencies.done(answer, sent);
    }

    private takeVolume(info: VolumeInfo, keepView: boolean): void {
        const grid = gridOf(info);
        this.volume = new VolumeData(grid, new Uint16Array(voxelCount(grid)));
        this.stage.setVolume(this.volume);
        this.stage.setOverlay(undefined);
        this.stage.setRest(undefined);
        this.received = 0;
        this.store.set({ volume: info, loaded: 0, pathFrom: null });
        if (keepView || takeUpView(this.store, this.memory)) return;
        const middle = worldFromVoxel(grid, mul(0.5, sub(grid.size, [1, 1, 1])));
        const start = info.start ?? { eye_mm: middle, look: [0, 1, 0], up: [0, 0, 1] };
        const size = norm(sub(worldFromVoxel(grid, grid.size), worldFromVoxel(grid, [0, 0, 0])));
        // Contrast agent and soft tissue, where there is a vessel.
        this.vesselIsNew = this.store.state.shared?.tissue?.has_vessel === true;
        if (this.vesselIsNew) this.store.set({ window: 700, level: 200 });
        this.store.set({
            camera: { eye: start.eye_mm, look: normalized(start.look), up: start.up },
            cursor: start.eye_mm,
            orbit: { centre: middle, direction: [0, 1, 0], up: [0, 0, 1], distance: 1.5 * size },
        });
    }

    // --- each frame

    tick(seconds: number, now: number): void {
        const dt = Math.min(seconds, kLongestFrame);
        if (this.volume && this.store.state.loaded >= 1) this.steer(dt);
        this.device.tick(dt, now);
        this.drive(dt, now);
        if (now - this.lastPose > kPoseMs) this.sendPose(now);
        if (this.stage.frame(now) && this.boxesSinceDraw) {
            this.boxesSinceDraw = 0;
            this.latencies.drawn();
        }
    }

    private steer(dt: number): void {
        const wish = this.steering();
        const moves = norm(wish.move) > 0 || wish.yaw || wish.pitch || wish.roll;
        if (moves && !this.flying) this.history.begin();
        if (!moves && this.flying) this.history.end('flight');
        this.flying = Boolean(moves);
        if (!moves) {
            if (!this.playMovie(dt)) this.followPath(dt);
            return;
        }
        this.stopMovie();
        if (this.store.state.pathFlying) this.togglePath(); // stepped off
        const angle = (kTurnRate * Math.PI * dt) / 180;
        this.turn(wish.yaw * angle, wish.pitch * angle, wish.roll * angle);
        if (norm(wish.move) > 0) {
            const { camera, speed } = this.store.state;
            const room = clearance(this.volume!, camera.eye, this.surface(), kRoomReach);
            const way = speed * speedFor(room) * dt;
            const { right, up, forward } = frameOf(camera);
            const [x, y, z] = normalized(wish.move);
            this.fly(mul(way, add(add(mul(x, right), mul(y, up)), mul(z, forward))));
        }
    }

    // --- a path

    setPath(path: Path): void {
        this.store.set({ path, pathFlying: false });
        this.goAlong(0);
    }

    /// To a place on the path, after some way from its start [mm].
    goAlong(way: number): void {
        const { path, camera } = this.store.state;
        if (!path) return;
        const pathWay = Math.min(Math.max(way, 0), path.length);
        const next = path.camera(pathWay, camera.up);
        this.store.set({ camera: next, cursor: next.eye, pathWay });
    }

    /// Flies on from the nearest place of the path, or pauses.
    togglePath(): void {
        const { path, pathFlying, camera, pathWay } = this.store.state;
        if (!path) return;
        if (pathFlying) this.history.end('path');
        else {
            this.history.begin();
            const nearest = path.nearest(camera.eye);
            const atEnd = Math.max(nearest, pathWay) > path.length - 0.5;
            this.store.set({ pathWay: atEnd ? 0 : nearest });
        }
        this.store.set({ pathFlying: !pathFlying });
    }

    private followPath(dt: number): void {
        const { path, pathFlying, pathWay, speed } = this.store.state;
        if (!path || !pathFlying) return;
        this.goAlong(pathWay + kPathSpeed * speed * dt);
        if (this.store.state.pathWay >= path.length) this.togglePath();
    }

    /// Turns the endoscope about its own axes [radians].
    turn(yaw: number, pitch: number, roll = 0): void {
        if (!yaw && !pitch && !roll) return;
        const { camera } = this.store.state;
        const { right, up, forward } = frameOf(camera);
        let look = turned(turned(forward, up, -yaw), turned(right, up, -yaw), pitch);
        look = normalized(look);
        const tilted = turned(turned(up, turned(right, up, -yaw), pitch), look, roll);
        this.store.set({ camera: { ...camera, look, up: tilted } });
    }

    /// Moves the tip, as the wall allows. The crosshair stays with the tip.
    fly(motion: Vec3): void {
        if (!this.volume) return;
        const { camera, wall, tip } = this.store.state;
        const from = camera.eye;
        if (wall === 'pass') this.moveEye(add(from, motion));
        else if (wall === 'stop' || this.store.state.role === 'view')
            this.moveEye(flown(this.volume, from, motion, tip, this.surface()));
        else this.pushOn(from, motion);
    }

    private pushOn(from: Vec3, motion: Vec3): void {
        if (this.pushing) return;
        const { tip } = this.store.state;
        const to = add(from, motion);
        if (!wouldTouch(this.volume!, from, to, tip, this.surface())) {
            this.moveEye(to);
            this.tipStroke = 0;
            return;
        }
        this.tipStroke ||= newStroke();
        this.pushing = true;
        const stroke = this.tipStroke;
        const what = pushOrSlide(this.store.state, true);
        const command: Command = { do: what, point: from, push: motion, radius: tip, stroke };
        void this.connection.ask(command).then((answer) => {
            this.pushing = false;
            note(this.store, answer);
            if (answer?.t !== 'done') return;
            // The eye may have been turned meanwhile, but not moved.
            this.moveEye(answer.end ?? along(from, answer.step_fraction ?? 1, motion));
            this.eyeIsFree = true; // once the voxels are here
        });
    }

    private isInTissue(eye: Vec3 = this.store.state.camera.eye): boolean {
        const { volume } = this;
        if (!volume) return false;
        return inTissue(volume.sample(voxelFromWorld(volume.grid, eye)), this.surface());
    }

    /// The eye is never in tissue: it gives way to tissue that has come to lie over it, and goes
    /// back when the tissue has gone.
    private keepEyeFree(): void {
        const { camera, wall, tip, loaded } = this.store.state;
        if (!this.volume || wall === 'pass' || loaded < 1) return;
        const back = this.displaced;
        if (back && norm(sub(back.to, camera.eye)) > 0) this.displaced = undefined; // it was moved
        else if (back && !this.isInTissue(back.from)) {
            this.displaced = undefined;
            this.moveEye(back.from);
            return;
        }
        if (!this.eyeIsFree || !this.isInTissue()) return;
        const to = freePlace(this.volume, camera.eye, tip, this.surface(), kEscape);
        if (!to) {
            this.say('tissue has closed around the endoscope');
            return;
        }
        const from = this.displaced?.from ?? camera.eye;
        this.moveEye(to);
        this.displaced = { from, to };
    }

    /// The endoscope is put somewhere else, walls or not.
    goTo(eye: Vec3, look: Vec3, up: Vec3 = naturalUp(look)): void {
        this.history.step('go to', () =>
            this.store.set({ camera: { eye, look: normalized(look), up }, cursor: eye }),
        );
    }

    private moveEye(eye: Vec3): void {
        const { camera } = this.store.state;
        this.store.set({ camera: { ...camera, eye }, cursor: eye });
    }

    private surface(): ReturnType<typeof surfaceOf> {
        return surfaceOf(this.store.state);
    }

    // --- tools

    /// The tool is put somewhere, before it does anything; or taken away.
    poise(place: Vec3 | undefined): void {
        const { tool, radius } = this.store.state;
        const kind = kHeads[tool];
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

    /// A tool that the endoscope itself is.
    private isEye(tool: Tool): boolean {
        const { device } = this;
        return device.follows && device.isOwn && tool.client === device.news?.tool;
    }

    placeBalls(): void {
        const balls: ToolBall[] = this.store.state.others
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
        const radius = held?.kind === 'blade' ? kBladeRadius : (held?.radius ?? 0);
        if (held && centre && radius > 0)
            balls.unshift({ centre, radius, own: true, kind: held.kind, closed: !!stroke?.closed });
        this.stage.setTools(balls);
    }

    private sendPose(now: number): void {
        if (!this.connection.isOpen || !this.volume) return;
        const { camera, tip, wall } = this.store.state;
        const at = this.stroke?.path[this.stroke.path.length - 1];
        const pose = {
            do: 'tool' as const,
            kind: at ? ('sphere' as const) : ('endoscope' as const),
            position: at ?? camera.eye,
            direction: camera.look,
            up: camera.up,
            radius: at ? this.stroke!.radius : wall === 'pass' ? 0 : tip,
        };
        const text = JSON.stringify(pose);
        if (text === this.poseText) return;
        this.poseText = text;
        this.lastPose = now;
        this.connection.tell(pose);
    }

    /// Asks the server for the checksum, and compares the voxels that are here with it.
    async compare(): Promise<(Checksum & { same: boolean; own: string }) | undefined> {
        let own = '';
        const answer = await this.connection.ask({ do: 'checksum' }, () => {
            own = this.volume ? checksumOf(this.volume.halves) : '';
        });
        if (answer?.t !== 'checksum') return undefined;
        return { ...answer, own, same: own === answer.voxels };
    }
}
