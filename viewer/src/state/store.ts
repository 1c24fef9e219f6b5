// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What the page shows, in one place. Views, panels and tools read it and are told what changed;
// nobody keeps a copy. What is the server's (threshold, materials, undo steps) comes from its state
// messages and is only asked for, never set here.

import type { Space } from '../maths/grid.ts';
import type { Keyframe } from '../maths/keyframes.ts';
import type { Path } from '../maths/path.ts';
import type { Camera, Surface } from '../maths/rays.ts';
import type { Vec3 } from '../maths/vec.ts';
import type {
    HapticsNews,
    OverlayKind,
    Role,
    SharedState,
    Tool,
    VolumeInfo,
} from '../net/protocol.ts';

export const kViews = ['endoscope', 'axial', 'coronal', 'sagittal'] as const;
export type ViewName = (typeof kViews)[number];
export type SectionName = Exclude<ViewName, 'endoscope'>;

/// Springs know no sliding: they are pushed.
export const pushOrSlide = (state: Readonly<State>, slide: boolean): 'push' | 'slide' =>
    slide && state.shared?.tissue?.model !== 'springs' ? 'slide' : 'push';

/// The wall that the state's threshold makes.
export const surfaceOf = (state: Readonly<State>): Surface => ({
    iso: state.shared?.iso_hu ?? -500,
    rising: state.shared?.polarity !== 'falling',
});

export const kTools = [
    'look',
    'window',
    'push',
    'grab',
    'cut',
    'carve',
    'path',
    'catheter',
] as const;
export type ToolName = (typeof kTools)[number];

/// What the tip does at a wall.
export const kWalls = ['stop', 'push', 'pass'] as const;
export type Wall = (typeof kWalls)[number];

/// Shape alone; or as an endoscope records it.
export type Style = 'plain' | 'real';

/// Kinds of lumen, each with its colours.
export const kLinings = ['airway', 'colon', 'sinus', 'vessel'] as const;
export type Lining = (typeof kLinings)[number];

/// Shapes of the picture's edge.
export const kFieldStops = ['round', 'octagon', 'full'] as const;
export type FieldStop = (typeof kFieldStops)[number];

export interface SectionFrame {
    readonly shift: readonly [number, number]; ///< of the picture's centre, right and up [mm]
    readonly zoom: number; ///< 1: the whole volume is in the picture
}

export interface State {
    link: 'connecting' | 'open' | 'lost' | 'ended';
    linkText: string;
    role: Role;
    client: number;
    program: string;
    features: string[];
    openBytes: number; ///< that a scan may have which is opened; 0: not said
    transfer: string; ///< what is being sent or saved; empty: nothing
    volume: VolumeInfo | null;
    loaded: number; ///< share of the first snapshot that is here, 0…1
    voxels: number; ///< grows whenever voxels changed
    shared: SharedState | null;
    hapticDevices: string[]; ///< that the server offers
    haptics: HapticsNews | null; ///< a device in somebody's hand
    others: Tool[]; ///< tools of other clients
    force: number; ///< on the own tool
    outcome: string; ///< of the last command, where there is something to say of it

    camera: Camera;
    style: Style; ///< of the endoscope's picture
    styleChosen: boolean; ///< by a person: it stays, however slow
    lining: Lining | 'auto'; ///< of the style real: which lumen it is
    fieldStop: FieldStop; ///< and the picture's shape
    outside: boolean; ///< the endoscope's view shows the lumen from outside
    fluoroscopy: boolean; ///< and X-rays through the scan instead
    fluoroContrast: number; ///< factor of the absorption
    fluoroExposure: number; ///< factor of the light that the picture needs
    fluoroField: FieldStop; ///< its collimator
    fluoroNoise: number; ///< factor of the quantum noise
    vessel: number; ///< grows whenever a vessel or its catheter moved; 0: there is none
    orbit: { centre: Vec3; direction: Vec3; up: Vec3; distance: number };
    fieldOfView: number; ///< [degrees]
    barrel: number;
    fog: number; ///< [mm]; 0: none
    speed: number; ///< factor
    wall: Wall;
    tip: number; ///< radius of the endoscope's tip [mm]
    path: Path | null; ///< a way through the lumen
    pathWay: number; ///< how far along it the endoscope is [mm]
    pathFlying: boolean;
    pathFrom: Vec3 | null; ///< where a way begins whose end is not chosen yet
    pathBusy: boolean; ///< a way is being looked for
    keyframes: readonly Keyframe[];
    moviePlaying: boolean;

    cursor: Vec3; ///< the crosshair [mm, LPS]
    pointer: { view: ViewName; point: Vec3 } | null;
    sections: Record<SectionName, SectionFrame>;
    window: number; ///< [HU]
    level: number; ///< [HU]
    contour: boolean; ///< the threshold as a line in the sections

    restVersion: number; ///< grows whenever the rest field changed

    overlay: OverlayKind; ///< what is shown in colours over the scan
    overlayVoxels: number; ///< grows whenever its numbers changed
    overlayExtreme: number; ///< their largest departure from rest
    overlayOpacity: number;
    overlayAuto: boolean; ///< the colours' range follows the numbers
    overlayMm: number; ///< else it ends here, for displacements [mm]
    overlayGrowth: number; ///< and so far from 1, for volume changes

    tool: ToolName;
    radius: number; ///< of the sphere probe [mm]
    strength: number; ///< share of the pointer's motion that the tool makes
    slide: boolean; ///< tissue slides off the sphere, instead of going along
    depth: number; ///< of a cut [mm]

    maximised: ViewName | null;
    active: ViewName; ///< what the keyboard acts on
    space: Space;
    theme: 'light' | 'dark' | 'system';
    timings: boolean;
    fine: boolean; ///< four rays per pixel when still
}

export type Listener = (state: State, changed: ReadonlySet<keyof State>) => void;

export class Store {
    private current: State;
    private readonly listeners: Listener[] = [];

    constructor(initial: State) {
        this.current = initial;
    }

    get state(): Readonly<State> {
        return this.current;
    }

    set(patch: Partial<State>): void {
        const changed = new Set<keyof State>();
        for (const key of Object.keys(patch) as (keyof State)[])
            if (this.current[key] !== patch[key]) changed.add(key);
        if (!changed.size) return;
        this.current = { ...this.current, ...patch };
        for (const listener of this.listeners) listener(this.current, changed);
    }

    listen(listener: Listener): void {
        this.listeners.push(listener);
    }

    /// Calls back now and whenever one of the keys changed.
    watch(keys: readonly (keyof State)[], react: (state: State) => void): void {
        react(this.current);
        this.listen((state, changed) => {
            if (keys.some((key) => changed.has(key))) react(state);
        });
    }
}

const kWhole: SectionFrame = { shift: [0, 0], zoom: 1 };

export const initialState = (): State => ({
    link: 'connecting',
    linkText: '',
    role: 'view',
    client: 0,
    program: '',
    features: [],
    openBytes: 0,
    transfer: '',
    volume: null,
    loaded: 0,
    voxels: 0,
    shared: null,
    hapticDevices: [],
    haptics: null,
    others: [],
    force: 0,
    outcome: '',
    camera: { eye: [0, 0, 0], look: [0, 1, 0], up: [0, 0, 1] },
    style: 'real',
    styleChosen: false,
    lining: 'auto',
    fieldStop: 'round',
    outside: false,
    fluoroscopy: false,
    fluoroContrast: 1,
    fluoroExposure: 1,
    fluoroField: 'round',
    fluoroNoise: 1,
    vessel: 0,
    orbit: { centre: [0, 0, 0], direction: [0, 1, 0], up: [0, 0, 1], distance: 300 },
    fieldOfView: 80,
    barrel: 0.15,
    fog: 120,
    speed: 1,
    wall: 'stop',
    tip: 2.5,
    path: null,
    pathWay: 0,
    pathFlying: false,
    pathFrom: null,
    pathBusy: false,
    keyframes: [],
    moviePlaying: false,
    cursor: [0, 0, 0],
    pointer: null,
    sections: { axial: kWhole, coronal: kWhole, sagittal: kWhole },
    window: 1500,
    level: -200,
    contour: false,
    restVersion: 0,
    overlay: 'none',
    overlayVoxels: 0,
    overlayExtreme: 0,
    overlayOpacity: 0.65,
    overlayAuto: true,
    overlayMm: 5,
    overlayGrowth: 0.5,
    tool: 'look',
    radius: 4,
    strength: 1,
    slide: false,
    depth: 10,
    maximised: null,
    active: 'endoscope',
    space: 'LPS',
    theme: 'system',
    timings: false,
    fine: true,
});
