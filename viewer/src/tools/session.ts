// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Session with the server: applies its messages to state, mirrors and stage, and advances
// everything that moves, once per frame.

import { autoWindow } from '../maths/auto_window.ts';
import { type Grid, voxelCount, worldBounds, worldFromVoxel } from '../maths/grid.ts';
import { halfOfFloat } from '../maths/half.ts';
import { checksumOf } from '../maths/murmur.ts';
import { roundTo } from '../maths/steps.ts';
import { mul, norm, normalized, sub } from '../maths/vec.ts';
import { VolumeData } from '../maths/volume.ts';
import type { CompanyNews } from '../net/company.ts';
import type { Listener, Memory } from '../net/connection.ts';
import { Latencies } from '../net/latencies.ts';
import {
    type BoxFrame,
    type Checksum,
    type Done,
    gridOf,
    kCoarseStep,
    type HapticsNews,
    type LabelsNews,
    type MarksNews,
    type Refusal,
    type SharedState,
    type Tool,
    type VolumeInfo,
    type Welcome,
} from '../net/protocol.ts';
import type { SurfaceFrame, VesselFrame } from '../net/vessel.ts';
import { keepView, takeUpView } from '../state/kept_view.ts';
import { initialReplay } from '../state/company.ts';
import { initialState, suits, tipIsInScan } from '../state/state.ts';
import type { Patch } from '../state/store.ts';
import {
    hasOwnWindow,
    isInHu,
    lengthFor,
    roundLength,
    scaleOf,
    windowOf,
} from '../state/units.ts';
import { kOutsideField } from '../views/orbit.ts';
import { CatheterHand } from './catheter_hand.ts';
import { Endoscope } from './endoscope.ts';
import { Follow } from './follow.ts';
import { Hand } from './hand.ts';
import { Haptics } from './haptics.ts';
import { LabelsTool } from './labels_tool.ts';
import { LumenTool } from './lumen_tool.ts';
import { MarksTool } from './marks_tool.ts';
import { Movie } from './movie.ts';
import { wordsOf } from './outcome.ts';
import { PathTool } from './path_tool.ts';
import { ReplayTool } from './replay_tool.ts';
import { Scene, type SceneParts } from './scene.ts';
import { steeringOf, type Stick } from './steering.ts';
import { Subscriptions } from './subscriptions.ts';
import { ThresholdTool } from './threshold.ts';
import { TipRide } from './tip_ride.ts';
import { TissueDefaults } from './tissue_defaults.ts';
import { followScan } from './volume_presets.ts';

const kLoadedStep = 0.1; // of the share that is shown while a scan is loaded
const kAirBelow = -500; // [HU]
const kToolVoxels = 2; // radius of a tool

/// Rounded settings of the tools that suit a scan. Tools of less than kToolVoxels would hold single
/// voxels, and draw a spike out of a wall that is thinner than the picture shows.
function toolsFor(info: VolumeInfo): Patch {
    const { tool, flight } = initialState();
    const [x, y, z] = gridOf(info).spacing;
    const voxels_mm = kToolVoxels * Math.cbrt(x * y * z);
    return {
        tool: {
            radius: Math.max(
                lengthFor(info, tool.radius, 0.5),
                roundTo(Math.max(info.tool_mm ?? 0, voxels_mm), roundLength(info, 0.5)),
            ),
            depth: lengthFor(info, tool.depth, 1),
        },
        flight: { tip: lengthFor(info, flight.tip, 0.5) },
    };
}
const kAround = 1.5; // distance of the outside view, in diagonals of the scan
const kWhole = 0.8; // share of the scan's sides that the first view from outside shows whole
const kAspect = 1.5; // of the views
const kLongestFrame = 0.1; // time step limit after a pause [s]

/// Scan of every kCoarseStep-th voxel, without values.
function coarseOf({ size, spacing, ...rest }: Grid): VolumeData {
    const nodes = size.map((n) => Math.ceil(n / kCoarseStep)) as unknown as Grid['size'];
    const grid = { ...rest, size: nodes, spacing: mul(kCoarseStep, spacing) };
    return new VolumeData(grid, new Uint16Array(voxelCount(grid)), true);
}

/// Distance from which the middle of the scan is shown whole.
function distanceOfWhole(grid: Grid): number {
    const { low, high } = worldBounds(grid);
    const [x, y, z] = mul(0.5 * kWhole, sub(high, low));
    return Math.max(x / kAspect, z) / Math.tan((kOutsideField * Math.PI) / 360) + y;
}

/// Change by one more layer beside which a depth is enough [mm].
const kWithin = 0.1;

export interface SessionParts extends SceneParts {
    /// The tab's storage, which outlives a reload.
    readonly memory: Memory;
    /// The browser's storage, which outlives the tab.
    readonly lasting: Memory;
    /// Codes of the keys that are held.
    readonly held: ReadonlySet<string>;
    /// Called after the server's welcome.
    onWelcome(): void;
}

export class Session extends Scene implements Listener {
    readonly latencies = new Latencies();
    readonly stick: Stick = { ahead: 0, right: 0 };
    readonly device = new Haptics(this);
    readonly hand = new Hand(this, this.device);
    readonly endoscope = new Endoscope(this);
    readonly threshold = new ThresholdTool(this);
    readonly path = new PathTool(this);
    readonly marks = new MarksTool(this);
    readonly lumen = new LumenTool(this);
    readonly labelMap = new LabelsTool(this);
    readonly movie = new Movie(this, this.path, this.threshold);
    readonly replay = new ReplayTool(this);
    readonly ride = new TipRide(this, () => {
        this.movie.stop();
        this.path.pause();
        this.follow.end();
    });
    readonly follow = new Follow(this, () => {
        this.movie.stop();
        this.path.pause();
    });
    readonly catheter: CatheterHand;
    readonly tissueDefaults: TissueDefaults;
    private readonly subscriptions = new Subscriptions(this);
    private readonly memory: Memory;
    private readonly held: ReadonlySet<string>;
    private readonly onWelcome: () => void;
    private coarse: VolumeData | undefined; // not complete
    private received = 0; // voxels of the first snapshot
    private boxesSinceDraw = 0;
    private fitsWindow = false; // a scan without air: the usual window would show nothing

    constructor(parts: SessionParts) {
        super(parts);
        this.memory = parts.memory;
        this.held = parts.held;
        this.tissueDefaults = new TissueDefaults(this, parts.lasting);
        this.onWelcome = () => parts.onWelcome();
        this.catheter = new CatheterHand(this, parts.held, this.stick, this.device);
        followScan(this);
    }

    /// Connects to the server.
    open(): void {
        this.connection.open(this);
    }

    // --- messages of the server

    welcome(message: Welcome): void {
        const isWatched = message.features.includes('replay');
        this.store.set({
            link: {
                status: 'open',
                text: '',
                role: isWatched ? 'view' : message.role,
                client: message.client,
                program: message.program,
                features: message.features,
                openBytes: message.open_bytes ?? 0,
            },
            device: { offered: message.haptic_devices ?? [], news: null },
            shared: message.state,
            replay: {
                ...initialReplay,
                isOn: isWatched,
                controls: isWatched && message.role === 'control',
            },
        });
        this.follow.renew();
        const held = this.volume && this.store.state.scan.volume?.id === message.volume.id;
        if (this.volume && !held) this.forgetScan();
        this.subscriptions.forgetFields();
        if (!message.resumed || !held) this.takeVolume(message.volume, held === true);
        this.subscriptions.askAgain();
        this.subscriptions.askVessel();
        this.labelMap.ask();
        this.marks.ask(message.resumed);
        this.tissueDefaults.take(message.state);
        this.onWelcome();
    }

    newVolume(info: VolumeInfo): void {
        this.forgetScan();
        this.subscriptions.forgetFields();
        this.takeVolume(info, false);
        this.subscriptions.askAgain();
        this.labelMap.ask();
        this.marks.ask(false);
        this.follow.renew();
    }

    state(shared: SharedState): void {
        const before = this.surface;
        this.store.set({ shared });
        if (!suits(this.store.state, this.store.state.tool.name))
            this.store.set({ tool: { name: 'look' } });
        if (this.store.state.scan.loaded === 1) this.tissueDefaults.take(shared);
        const { iso, rising } = this.surface;
        if (iso !== before.iso || rising !== before.rising) this.endoscope.judgeEye();
        this.tellSteps();
    }

    box(frame: BoxFrame): void {
        const texture = this.stage.texture;
        if (!texture || !this.volume) return;
        const { loaded, voxels } = this.store.state.scan;
        if (loaded < 1) texture.fill(frame.box, frame.halves, frame.last);
        else texture.patch(frame.box, frame.halves);
        ++this.boxesSinceDraw;
        if (loaded < 1) {
            this.received += frame.halves.length;
            const share = Math.min(this.received / voxelCount(this.volume.grid), 0.99);
            // Each step is drawn, which takes time as well.
            if (frame.last || share >= loaded + kLoadedStep)
                this.store.set({ scan: { loaded: frame.last ? 1 : share } });
        }
        if (!frame.last) return;
        // The server takes commands for another scan once it knows that its voxels are here.
        if (loaded < 1) setTimeout(() => this.tissueDefaults.take(this.store.state.shared!));
        this.fitWindow(this.volume);
        this.latencies.arrived(frame.step);
        this.store.set({ scan: { voxels: voxels + 1 } });
        this.subscriptions.openVessel();
        const { company, view } = this.store.state;
        if (!company.leader && !view.onTip) this.endoscope.keepEyeFree();
    }

    /// Takes a part of the coarse scan, which is shown while the voxels arrive.
    coarseBox({ box, halves, last }: BoxFrame): void {
        if (!this.volume || this.store.state.scan.loaded >= 1) return;
        this.coarse ??= coarseOf(this.volume.grid);
        this.coarse.fill(box, halves);
        if (!last) return;
        this.coarse.finish();
        this.stage.setCoarse(this.coarse);
        this.fitWindow(this.coarse);
        this.coarse = undefined;
    }

    overlayBox(frame: BoxFrame): void {
        this.subscriptions.overlayBox(frame);
    }

    restBox(frame: BoxFrame): void {
        this.subscriptions.restBox(frame);
    }

    labelBox(frame: BoxFrame): void {
        this.labelMap.box(frame);
    }

    labels(news: LabelsNews): void {
        this.labelMap.take(news);
    }

    marksNews(news: MarksNews): void {
        this.marks.take(news);
    }

    companyNews(news: CompanyNews): void {
        if (news.t === 'camera') this.follow.take(news);
        else this.replay.take(news);
    }

    vesselFrame(frame: SurfaceFrame | VesselFrame): void {
        this.subscriptions.vesselFrame(frame);
    }

    tools(tools: Tool[]): void {
        const { client } = this.connection;
        const own = tools.find((tool) => tool.client === client);
        const others = tools.filter((tool) => tool.client !== client);
        const force_n = own ? norm(own.force_n) : 0;
        const energy_per_mm = own ? norm(own.energy_per_mm) : 0;
        this.store.set({ hands: { others, force_n, energy_per_mm } });
        this.hand.placeBalls();
    }

    haptics(news: HapticsNews): void {
        this.device.take(news, performance.now());
    }

    refused(refusal: Refusal): void {
        // A leader that has left is told by Follow.
        if (refusal.do === 'follow') return;
        const words = wordsOf(refusal, this.store.state);
        if (words) this.warn(words);
    }

    silent(is: boolean): void {
        this.store.set({ link: { silent: is } });
    }

    lost(status: 'lost' | 'ended' | 'refused', reason: string): void {
        this.hand.forget();
        this.store.set({ link: { status, text: reason } });
        this.device.forget();
    }

    done(answer: Done, sent: number): void {
        this.latencies.done(answer, sent);
    }

    // --- scans

    /// Forgets everything that belongs to the present scan, before another one is shown.
    private forgetScan(): void {
        keepView(this.store, this.memory);
        this.hand.forget();
        this.endoscope.forget();
        this.history.clear();
        this.subscriptions.forgetVessel();
        this.labelMap.forget();
        this.marks.forget();
        const { frames, window, level } = initialState().sections;
        this.store.set({
            way: { path: null, flying: false, position: 0 },
            lumen: { tip: null, along: [], share: 1 },
            tool: { cuts: [], outcome: null },
            hands: { force_n: 0, energy_per_mm: 0 },
            sections: { frames, window, level },
            view: { onTip: false },
            rendering: initialState().rendering,
        });
        this.hand.placeBalls();
    }

    private takeVolume(info: VolumeInfo, keepsView: boolean): void {
        const before = this.store.state.scan.volume;
        const grid = gridOf(info);
        const missing = halfOfFloat(info.range_hu[0]); // dark in the sections
        this.volume = new VolumeData(grid, new Uint16Array(voxelCount(grid)).fill(missing), true);
        this.coarse = undefined;
        this.stage.setVolume(this.volume);
        this.stage.setOverlay(undefined);
        this.stage.setRest(undefined);
        this.received = 0;
        this.fitsWindow = false;
        this.store.set({ scan: { volume: info, loaded: 0 }, way: { from: null } });
        if (keepsView || takeUpView(this.store, this.memory)) return;
        const middle = worldFromVoxel(grid, mul(0.5, sub(grid.size, [1, 1, 1])));
        const start: NonNullable<VolumeInfo['start']> = info.start ?? {
            eye_mm: middle,
            look: [0, 1, 0],
            up: [0, 0, 1],
        };
        const outside = start.outside === true;
        const size = norm(sub(worldFromVoxel(grid, grid.size), worldFromVoxel(grid, [0, 0, 0])));
        const hasVessel = this.store.state.shared?.tissue?.has_vessel === true;
        this.subscriptions.expectVessel(hasVessel);
        const isOwn = !isInHu(info) || hasOwnWindow(info);
        this.fitsWindow = !isOwn && !hasVessel && info.range_hu[0] > kAirBelow;
        this.store.set(toolsFor(info));
        this.fitLengths(scaleOf(info) / scaleOf(before));
        // Else, in a vessel, a window for contrast medium and soft tissue.
        const shown = isOwn || !hasVessel ? windowOf(info) : { window: 700, level: 200 };
        this.store.set({ sections: shown });
        this.store.set({
            view: {
                camera: { eye: start.eye_mm, look: normalized(start.look), up: start.up },
                orbit: {
                    centre: middle,
                    direction: [0, 1, 0],
                    up: [0, 0, 1],
                    distance: outside ? distanceOfWhole(grid) : kAround * size,
                },
                ...(outside ? { outside } : {}),
            },
        });
        const isWithin = tipIsInScan(this.store.state);
        this.store.set({ sections: { cursor: outside && !isWithin ? middle : start.eye_mm } });
    }

    /// Keeps what the user has set, as a share of the scan's size. @param ratio  of the sizes
    private fitLengths(ratio: number): void {
        const { view, sections, overlay } = this.store.state;
        const fitted = (mm: number): number =>
            ratio === 1 ? mm : Number((ratio * mm).toPrecision(6));
        this.store.set({
            view: { fog: fitted(view.fog) },
            sections: { slab: fitted(sections.slab) },
            overlay: { mm: fitted(overlay.mm) },
        });
    }

    // --- frames

    /// Fits the window of the sections to a scan, once.
    private fitWindow(volume: VolumeData): void {
        if (this.fitsWindow) this.store.set({ sections: autoWindow(volume) });
        this.fitsWindow = false;
    }

    /// Advances by a frame's time, and draws.
    tick(seconds: number, now: number): void {
        const dt = Math.min(seconds, kLongestFrame);
        if (this.volume && this.store.state.scan.loaded >= 1) this.move(dt, now);
        this.device.tick(dt, now);
        this.catheter.tick(dt, now);
        this.hand.follow();
        this.hand.sendPose(now, this.endoscope.holdingRadius);
        this.follow.tell(now);
        this.lumen.tick(now);
        this.labelMap.tick(now);
        if (this.stage.frame(now) && this.boxesSinceDraw) {
            this.boxesSinceDraw = 0;
            this.latencies.drawn();
        }
    }

    /// Moves the endoscope: by keys, which end movies and flights along paths, else by a movie,
    /// with another client, with the catheter's tip, or along a path.
    private move(seconds: number, now: number): void {
        const steering = steeringOf(this.held, this.stick, this.store.state);
        if (this.endoscope.takeUp(steering)) {
            this.movie.stop();
            this.path.pause();
            this.endoscope.steer(steering, seconds);
        } else if (!this.movie.tick(seconds)) {
            const { flying } = this.store.state.way;
            const isLed =
                !flying && (this.follow.tick(seconds, now) || this.ride.tick(seconds));
            if (!isLed) this.path.follow(seconds);
        }
    }

    /// Sets the least depth of forces of springs that changes little for the held tissue.
    async findDepth(): Promise<void> {
        const done = await this.ask({ do: 'depth', within_mm: kWithin });
        if (done) this.say(`one more layer moves nothing by more than ${kWithin} mm`);
        else this.warn('to find the depth, hold tissue with the mouse and press Shift+X');
    }

    /// Compares the voxels of the page with the server's, by their checksum.
    async compare(): Promise<(Checksum & { same: boolean; own: string }) | undefined> {
        let own = '';
        const answer = await this.connection.ask({ do: 'checksum' }, () => {
            own = this.volume ? checksumOf(this.volume.halves) : '';
        });
        if (answer?.t !== 'checksum') return undefined;
        return { ...answer, own, same: own === answer.voxels };
    }
}
