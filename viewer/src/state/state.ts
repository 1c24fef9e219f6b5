// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The state of the page in groups of values that change together, and its initial values. Views and
// panels depend on whole groups. `shared` is the server's: it comes with its state messages and is
// only asked for, never set here.

import { type Space, voxelFromWorld } from '../maths/grid.ts';
import type { Keyframe } from '../maths/keyframes.ts';
import type { CrossSection } from '../maths/lumen.ts';
import type { Mark } from '../maths/marks.ts';
import type { Path } from '../maths/path.ts';
import type { Camera, Surface } from '../maths/rays.ts';
import { kMuscle, type Transfer } from '../maths/transfer.ts';
import type { Vec3 } from '../maths/vec.ts';
import {
    gridOf,
    type HapticsNews,
    type OverlayKind,
    type Role,
    type SharedState,
    type Tool,
    type VolumeInfo,
} from '../net/protocol.ts';
import { type Company, initialCompany, initialReplay, type Replay } from './company.ts';
import { initialLabels, type Labels } from './labels.ts';

export const kViews = ['endoscope', 'axial', 'coronal', 'sagittal'] as const;
export type ViewName = (typeof kViews)[number];
export type SectionName = Exclude<ViewName, 'endoscope'>;

export const kTools = [
    'look',
    'window',
    'push',
    'grab',
    'cut',
    'carve',
    'path',
    'catheter',
    'measure',
] as const;
export type ToolName = (typeof kTools)[number];

/// Tools of clients that only view.
export const kViewing: readonly ToolName[] = ['look', 'window', 'path', 'measure'];

/// Behaviour of the tip at a wall.
export const kWalls = ['stop', 'push', 'pass'] as const;
export type Wall = (typeof kWalls)[number];

/// Shaded shape, or the picture of a real endoscope.
export type Style = 'plain' | 'real';

/// Kinds of lumen, each with its colours.
export const kLinings = ['airway', 'colon', 'sinus', 'vessel'] as const;
export type Lining = (typeof kLinings)[number];

/// Shapes of the picture's edge.
export const kFieldStops = ['round', 'octagon', 'full'] as const;
export type FieldStop = (typeof kFieldStops)[number];

/// Refused: the link's token is wrong.
export type LinkStatus = 'connecting' | 'open' | 'lost' | 'ended' | 'refused';
/// Projections of a slab in the sections.
export const kProjections = ['maximum', 'minimum', 'mean'] as const;
export type Projection = (typeof kProjections)[number];

/// The connection, and the server's abilities.
export interface Link {
    readonly status: LinkStatus;
    readonly silent: boolean; ///< the server has not answered for some seconds
    readonly text: string; ///< reason for a status other than open
    readonly role: Role; ///< view in a recorded session
    readonly client: number;
    readonly program: string;
    readonly features: readonly string[];
    readonly openBytes: number; ///< largest scan that may be opened; 0: unknown
    readonly transfer: string; ///< file being sent or saved, as a line for the user; empty: none
}

/// The scan, and the overlay on its grid. Drawn in all views.
export interface Scan {
    readonly volume: VolumeInfo | null;
    readonly loaded: number; ///< share of the first snapshot that has arrived, 0…1
    readonly voxels: number; ///< version of the voxels: grows with each change
    readonly overlay: number; ///< version of the overlay's values
    readonly extreme: number; ///< their largest departure from rest
}

/// Versions of the data that the endoscope's view alone draws; they grow with each change.
export interface Versions {
    readonly rest: number; ///< the rest field
    readonly vessel: number; ///< the vessel and its catheter; 0: none
}

/// Devices with force feedback.
export interface Device {
    readonly offered: readonly string[]; ///< names that the server offers
    readonly news: HapticsNews | null; ///< of the device in use, by any client
}

/// Tools at work.
export interface Hands {
    readonly others: readonly Tool[]; ///< tools of other clients
    // Force on the own tool; energy per path where the tissue has no forces [mm² · weight/mm].
    readonly force_n: number;
    readonly energy_per_mm: number;
}

/// Camera of the outside view.
export interface Orbit {
    readonly centre: Vec3;
    readonly direction: Vec3; ///< unit, from the eye to the centre
    readonly up: Vec3;
    readonly distance: number; ///< [mm]
}

/// The endoscope's view. Can be undone.
export interface View {
    readonly camera: Camera;
    readonly onTip: boolean; ///< the camera rides on the tip of the vessel's catheter
    readonly fieldOfView: number; ///< [degrees]
    readonly barrel: number; ///< distortion of the lens
    readonly fog: number; ///< [mm]; 0: none
    readonly outside: boolean; ///< the lumen is seen from outside
    readonly fluoroscopy: boolean; ///< from outside: X-rays through the scan
    readonly blended: boolean; ///< from outside, without fluoroscopy: the scan as a volume
    readonly orbit: Orbit;
}

export interface SectionFrame {
    readonly shift: readonly [number, number]; ///< of the picture's centre, right and up [mm]
    readonly zoom: number; ///< 1: the whole volume is in the picture
}

/// The three sections. Can be undone.
export interface Sections {
    readonly cursor: Vec3; ///< the crosshair [mm, LPS]
    readonly frames: Readonly<Record<SectionName, SectionFrame>>;
    readonly window: number; ///< [HU]
    readonly level: number; ///< [HU]
    readonly slab: number; ///< thickness [mm]; 0: a plane
    readonly projection: Projection; ///< of the slab
}

/// Style of the endoscope's picture.
export interface Look {
    readonly style: Style;
    readonly styleChosen: boolean; ///< by the user: kept on slow machines
    readonly lining: Lining | 'auto'; ///< of the style real
    readonly fieldStop: FieldStop; ///< of the style real
}

/// Fluoroscopy.
export interface Fluoro {
    readonly contrast: number; ///< factor of the absorption
    readonly exposure: number; ///< factor of the automatic exposure
    readonly noise: number; ///< factor of the quantum noise
    readonly field: FieldStop; ///< collimator
    readonly biplane: boolean; ///< with a second plane, at 90°
}

/// Volume rendering. Can be undone.
export interface Rendering {
    readonly preset: string; ///< name of the chosen one; empty: none yet
    readonly transfer: Transfer; ///< of the preset
    readonly opacity: number; ///< factor of its extinctions
    readonly shift: number; ///< of its values [HU]
    readonly cut: boolean; ///< open at the plane through the endoscope's tip
}

/// Settings of free flight.
export interface Flight {
    readonly speed: number; ///< factor
    readonly wall: Wall;
    readonly tip: number; ///< radius of the endoscope's tip [mm]
}

/// A path through the lumen.
export interface Way {
    readonly path: Path | null;
    readonly position: number; ///< of the endoscope, from the path's start [mm]
    readonly flying: boolean;
    readonly from: Vec3 | null; ///< chosen start of a path without an end
    readonly busy: boolean; ///< the server computes a path
}

export interface MovieState {
    readonly keyframes: readonly Keyframe[];
    readonly playing: boolean;
}

/// Settings of the coloured overlay.
export interface OverlaySettings {
    readonly kind: OverlayKind;
    readonly opacity: number;
    readonly auto: boolean; ///< the range of the colours follows the values
    readonly mm: number; ///< else: its end, for displacements [mm]
    readonly growth: number; ///< else: its half width around 1, for volume changes
}

/// Result of a command that did not go as wished.
export interface Outcome {
    readonly text: string;
    readonly place: Vec3; ///< of the tool [mm, LPS]
    readonly obstacle: Vec3 | null; ///< bone that stopped the tool [mm, LPS]
    readonly isStopped: boolean;
}

/// A cut by this client: the surface between a line and the same line at a depth.
export interface CutMark {
    readonly line: readonly Vec3[]; ///< [mm, LPS]
    readonly depth: Vec3; ///< [mm]
    readonly steps: number; ///< the server's steps of undo with it
}

export interface ToolSettings {
    readonly name: ToolName;
    readonly radius: number; ///< of the sphere probe [mm]
    readonly strength: number; ///< motion of the tool over motion of the pointer
    readonly slide: boolean; ///< tissue slides off the sphere
    readonly depth: number; ///< of a cut [mm]
    readonly follow: boolean; ///< the sections go with the tool and the catheter's tip
    readonly cuts: readonly CutMark[];
    readonly outcome: Outcome | null; ///< of the last command, for some seconds
}

/// Marks and measurements.
export interface Marks {
    readonly list: readonly Mark[]; ///< can be undone
    readonly kind: 'point' | 'ruler' | 'angle'; ///< of the next mark
    readonly pending: readonly Vec3[]; ///< its points so far, at rest [mm, LPS]
    readonly selected: string; ///< key; empty: none
}

/// Size of the lumen at a position on a path; null where its section is open.
export interface LumenAt {
    readonly way: number; ///< from the path's start [mm]
    readonly size: Pick<CrossSection, 'area' | 'equivalent' | 'inscribed'> | null;
}

/// Measured sizes of the lumen.
export interface LumenState {
    readonly on: boolean; ///< at the tip, continuously
    readonly tip: CrossSection | 'open' | null; ///< null: unknown, or the tip is in tissue
    readonly along: readonly LumenAt[]; ///< of the present path; may be incomplete
    readonly step: number; ///< of the voxels that they were measured in
    readonly share: number; ///< measured share of the path; 1: complete
}

/// Arrangement of the page.
export interface Display {
    readonly maximised: ViewName | null;
    readonly contour: boolean; ///< the threshold as a line in the sections
    readonly airFollows: boolean; ///< the tissue's air follows the threshold
    readonly space: Space;
    readonly theme: 'light' | 'dark' | 'system';
    readonly timings: boolean;
    readonly fine: boolean; ///< four rays per pixel when still
}

export interface PointerState {
    readonly active: ViewName; ///< target of keys
    readonly under: { readonly view: ViewName; readonly point: Vec3 } | null;
}

export interface State {
    readonly link: Link;
    readonly scan: Scan;
    readonly versions: Versions;
    readonly shared: SharedState | null;
    readonly device: Device;
    readonly hands: Hands;
    readonly view: View;
    readonly sections: Sections;
    readonly look: Look;
    readonly fluoro: Fluoro;
    readonly rendering: Rendering;
    readonly flight: Flight;
    readonly way: Way;
    readonly movie: MovieState;
    readonly overlay: OverlaySettings;
    readonly tool: ToolSettings;
    readonly marks: Marks;
    readonly lumen: LumenState;
    readonly labels: Labels;
    readonly company: Company;
    readonly replay: Replay;
    readonly display: Display;
    readonly pointer: PointerState;
}

const kWhole: SectionFrame = { shift: [0, 0], zoom: 1 };

export const initialState = (): State => ({
    link: {
        status: 'connecting',
        silent: false,
        text: '',
        role: 'view',
        client: 0,
        program: '',
        features: [],
        openBytes: 0,
        transfer: '',
    },
    scan: { volume: null, loaded: 0, voxels: 0, overlay: 0, extreme: 0 },
    versions: { rest: 0, vessel: 0 },
    shared: null,
    device: { offered: [], news: null },
    hands: { others: [], force_n: 0, energy_per_mm: 0 },
    view: {
        camera: { eye: [0, 0, 0], look: [0, 1, 0], up: [0, 0, 1] },
        onTip: false,
        fieldOfView: 80,
        barrel: 0.15,
        fog: 120,
        outside: false,
        fluoroscopy: false,
        blended: false,
        orbit: { centre: [0, 0, 0], direction: [0, 1, 0], up: [0, 0, 1], distance: 300 },
    },
    sections: {
        cursor: [0, 0, 0],
        frames: { axial: kWhole, coronal: kWhole, sagittal: kWhole },
        window: 1500,
        level: -200,
        slab: 0,
        projection: 'maximum',
    },
    look: { style: 'real', styleChosen: false, lining: 'auto', fieldStop: 'round' },
    fluoro: { contrast: 1, exposure: 1, noise: 1, field: 'round', biplane: false },
    rendering: {
        preset: '',
        transfer: kMuscle,
        opacity: 1,
        shift: 0,
        cut: false,
    },
    flight: { speed: 1, wall: 'stop', tip: 2.5 },
    way: { path: null, position: 0, flying: false, from: null, busy: false },
    movie: { keyframes: [], playing: false },
    overlay: { kind: 'none', opacity: 0.65, auto: true, mm: 5, growth: 0.5 },
    tool: {
        name: 'look',
        radius: 4,
        strength: 1,
        slide: false,
        depth: 10,
        follow: true,
        cuts: [],
        outcome: null,
    },
    marks: { list: [], kind: 'ruler', pending: [], selected: '' },
    lumen: { on: false, tip: null, along: [], step: 0, share: 1 },
    labels: initialLabels,
    company: initialCompany,
    replay: initialReplay,
    display: {
        maximised: null,
        contour: false,
        airFollows: false,
        space: 'LPS',
        theme: 'system',
        timings: false,
        fine: true,
    },
    pointer: { active: 'endoscope', under: null },
});

/// Tests whether the tissue takes a command.
export const takes = (state: State, command: 'push' | 'slide' | 'cut' | 'carve'): boolean =>
    state.shared?.tissue?.takes?.includes(command) ?? true;

/// Tests whether a tool works on the tissue.
export function suits(state: State, tool: ToolName): boolean {
    if (tool === 'push' || tool === 'grab') return takes(state, 'push');
    return (tool !== 'cut' && tool !== 'carve') || takes(state, tool);
}

/// Tests whether the tissue has ChainMail's materials.
export const hasMaterials = ({ shared }: State): boolean =>
    (shared?.tissue?.model ?? 'chainmail') === 'chainmail';

/// Command that moves a sphere through the tissue: some know no sliding and are pushed.
export const pushOrSlide = (state: State, slide: boolean): 'push' | 'slide' =>
    slide && takes(state, 'slide') ? 'slide' : 'push';

/// The wall at the state's threshold.
export const surfaceOf = (state: State): Surface => ({
    iso: state.shared?.iso_hu ?? -500,
    rising: state.shared?.polarity !== 'falling',
});

/// Tests whether the endoscope's tip is within the scan, which is then cut open there.
export function tipIsInScan({ scan: { volume }, view: { camera } }: State): boolean {
    if (!volume) return false;
    const ijk = voxelFromWorld(gridOf(volume), camera.eye);
    return ijk.every((x, a) => x >= -0.5 && x <= volume.size[a]! - 0.5);
}

/// Tests whether the tissue in use has a catheter, and not only the scan's voxels.
export const hasVessel = (state: State): boolean => state.shared?.vessel !== undefined;

/// Tests whether the scene has a catheter, perhaps of a tissue that isn't in use.
export const offersVessel = (shared: State['shared']): boolean =>
    shared?.vessel !== undefined || shared?.tissue?.has_vessel === true;
