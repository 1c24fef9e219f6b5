// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Messages of docs/developers/protocol.md as types, and the decoder of its binary frames. Invalid
// frames are refused with an error that names the field, so that no rubbish is drawn.

import type { Box, Grid } from '../maths/grid.ts';
import type { MarkKind } from '../maths/marks.ts';
import type { Mat3, Vec3 } from '../maths/vec.ts';
import type { CompanyCommand, CompanyNews } from './company.ts';
import type { Drive, ElasticSettings, Materials, SpringSettings } from './settings.ts';
import { decodeSurface, decodeVessel, type SurfaceFrame, type VesselFrame } from './vessel.ts';

export const kProtocol = 2;

/// Overlays that a client can ask for.
export const kOverlays = ['none', 'displacement', 'jacobian'] as const;
export type OverlayKind = (typeof kOverlays)[number];

export type Role = 'control' | 'view';
export type Polarity = 'rising' | 'falling';

export interface Timing {
    solve_ms: number;
    resample_ms: number;
    tick_ms: number;
    overlay_ms?: number;
    moved_elements: number;
}

/// State of the tissue model, with the settings of springs or of the elastic scan.
export interface TissueState extends Partial<SpringSettings>, Partial<ElasticSettings> {
    model: 'chainmail' | 'springs' | 'elastic' | 'vessel' | 'own';
    takes?: readonly ('push' | 'slide' | 'cut' | 'carve')[]; ///< commands
    has_vessel?: boolean; ///< the scene offers the model vessel
    has_own?: boolean; ///< likewise own, such as organs
    trouble?: string; ///< reason why the tissue was stopped before it came to rest
    centre?: Vec3;
    nodes?: Vec3 | number; ///< of springs along each axis; of the elastic scan in all
    active_nodes?: number;
    depth_by_time?: boolean; ///< the server adapts the depth
    line_mb_s?: number; ///< rate of the slowest client's line, if that limits the depth
    update_hz?: number;
    // Organs only.
    particles?: number;
    fixed_particles?: number;
    edge_mm?: number; ///< mean edge of the tetrahedra
    time_step_ms?: number;
    bodies?: string; ///< a line each
}

/// A model that a client chooses, with settings of springs or of the elastic scan.
export interface TissueChoice extends Partial<SpringSettings>, Partial<ElasticSettings> {
    model: TissueState['model'];
    centre?: Vec3;
    nodes?: number;
}

/// Drive of the catheter, and the forces on the hand.
export interface VesselState extends Drive {
    inserted_mm: number;
    rotated_deg: number;
    force_n: number; ///< on the hand, along the catheter
    torque_n_mm: number;
    contact_n: number;
    depth_mm: number; ///< largest depth of the catheter beyond the wall; below 0: clearance
    wall_moved_mm: number;
    time_s: number;
    pace: number; ///< simulated over real time; 0: unknown
    sub_steps: number; ///< of the last step
    radius_mm: number;
    length_mm: number;
    warnings: string[]; ///< faults of this state, a line each
    failure: string; ///< reason of a stop that lasts until a reset
}

export interface SharedState {
    step: number;
    iso_hu: number;
    polarity: Polarity;
    materials: Materials;
    tissue?: TissueState;
    vessel?: VesselState;
    relaxing: boolean;
    settled: boolean;
    holder: number;
    undo: { steps: number; next: string };
    redo: { steps: number; next: string };
    clients: { client: number; name: string; role: Role }[];
    recorded?: boolean; ///< false: commands are missing in the session's file
    timing: Timing;
}

export interface Landmark {
    name: string;
    point_mm: Vec3;
    push_mm: Vec3;
    eye_mm: Vec3;
    look: Vec3;
}

/// Kind of a scan's values, and defaults that suit them.
export interface ScanValues {
    kind: string; ///< as in docs/howto/kinds_of_scans.md
    unit: string; ///< HU, or empty: none
    window: number; ///< of sections
    level: number;
    iso: number; ///< threshold
    polarity: Polarity;
}

export interface VolumeInfo {
    id: number;
    name: string;
    size: Vec3;
    spacing_mm: Vec3;
    origin_mm: Vec3;
    direction: Mat3;
    range_hu: [number, number];
    values?: ScanValues;
    length_scale?: number; ///< usual lengths of tools and ways over those in a body
    /// First view; with outside, the whole is shown first.
    start: { eye_mm: Vec3; look: Vec3; up: Vec3; outside?: boolean } | null;
    tool_mm?: number; ///< radius of tools that suits the mesh of organs
    landmarks: Landmark[];
}

export interface Welcome {
    t: 'welcome';
    protocol: number;
    program: string;
    client: number;
    role: Role;
    resume: string;
    resumed: boolean;
    rate_hz: number;
    features: string[];
    open_bytes?: number;
    haptic_devices?: string[];
    volume: VolumeInfo;
    state: SharedState;
}

export interface Done {
    t: 'done';
    id: number;
    do: string;
    step: number;
    status?: 'applied' | 'limited' | 'rejected';
    limited_by?: 'none' | 'bone' | 'movement' | 'wall' | 'fold';
    step_fraction?: number;
    grabbed_elements?: number;
    moved_elements?: number;
    cut_links?: number;
    carved_elements?: number;
    bone?: Vec3; ///< that stopped the tool, nearest to it [mm, LPS]
    solve_ms?: number;
    force_n?: Vec3; ///< on the tool
    end?: Vec3; ///< of a slide: final centre of the sphere, outside of tissue [mm, LPS]
    whose?: number[]; ///< clients whose step was undone or redone
    message?: string;
}

export interface Refusal {
    t: 'error';
    id: number;
    do: string;
    code: string;
    message: string;
}

export interface Checksum {
    t: 'checksum';
    id: number;
    step: number;
    voxels: string;
    volume: string;
    tissue: string;
}

/// Path through the lumen.
export interface PathFound {
    t: 'path';
    id: number;
    step: number;
    volume: number;
    length_mm: number;
    points: Vec3[];
    radii: number[]; ///< distance of each point to the wall [mm]
}

/// State of the device with force feedback, of any client; all optional fields but why while it is
/// on.
export interface HapticsNews {
    t: 'haptics';
    on: boolean;
    why?: string; ///< reason of its end
    client?: number;
    tool?: number;
    device?: string;
    scale?: number;
    stopped?: boolean;
    contact?: boolean;
    lost?: boolean;
    place_mm?: Vec3;
    proxy_mm?: Vec3;
    force_n?: Vec3;
    largest_n?: number; ///< largest force since the previous message
    depth_mm?: number;
    holds?: 'catheter'; ///< instead of a tool
    largest_force_n?: number;
    servo?: {
        rate_hz: number;
        period_p99_us: number;
        period_max_us: number;
        misses_per_million: number;
        compute_p99_us: number;
        age_ms: number;
    };
    note?: string;
}

/// The label map beside the scan; without labels: there is none.
export interface LabelsNews {
    t: 'labels';
    volume: number;
    name: string; ///< of the file
    labels: {
        value: number;
        name: string;
        colour?: Vec3; ///< sRGB, 0…1
        voxels: number;
        centre_mm: Vec3;
        body?: number; ///< that carries it, from 1
        shown?: boolean; ///< at first; absent: yes
    }[];
}

/// A shared mark; of a deleted one key and kind alone.
export interface SharedMark {
    key: string;
    kind: MarkKind | 'none';
    name?: string;
    points?: readonly Vec3[]; ///< at rest
    shown?: boolean;
}
export type MarksNews = { t: 'marks'; marks: SharedMark[] } | ({ t: 'mark' } & SharedMark);

/// Answers to commands.
export type Answer = Done | Refusal | Checksum | PathFound;

export type ServerText =
    | Welcome
    | ({ t: 'volume' } & VolumeInfo)
    | ({ t: 'state' } & SharedState)
    | HapticsNews
    | LabelsNews
    | MarksNews
    | CompanyNews
    | Answer
    | { t: 'pong'; id: number }
    | { t: 'bye'; code: number; message: string };

/// Commands of clients, as in the protocol. The connection adds the id.
export type Command =
    | { do: 'push' | 'slide'; point: Vec3; push: Vec3; radius: number; stroke?: number }
    | { do: 'grab'; point: Vec3; radius: number; reach?: number }
    | { do: 'drag'; offset: Vec3 }
    | { do: 'let_go' | 'release' | 'reset' | 'undo' | 'redo' | 'checksum' | 'ping' }
    | { do: 'cut'; line: Vec3[]; depth: Vec3 }
    | {
          do: 'carve';
          from: Vec3;
          to: Vec3;
          radius: number;
          spare_fixed?: boolean;
          stroke?: number;
      }
    | { do: 'path'; from: Vec3; to: Vec3; reach?: number; iso_hu?: number; polarity?: Polarity }
    | { do: 'relax'; on: boolean }
    | ({ do: 'materials' } & Partial<Materials>)
    | ({ do: 'tissue' } & TissueChoice)
    | { do: 'depth'; layers: number }
    | { do: 'depth'; within_mm: number }
    | { do: 'depth'; by_time: boolean }
    | ({ do: 'catheter' } & Partial<Drive>)
    | { do: 'vessel'; on: boolean }
    | { do: 'iso'; iso_hu?: number; polarity?: Polarity }
    | {
          do: 'haptics';
          wish: 'start';
          device: string;
          position: Vec3;
          look: Vec3;
          up: Vec3;
          scale?: number;
          radius?: number;
      }
    | { do: 'haptics'; wish: 'stop' | 'go' | 'end' }
    | { do: 'overlay'; kind: OverlayKind }
    | { do: 'rest' | 'labels' | 'marks'; on: boolean }
    | ({ do: 'mark' } & SharedMark)
    | CompanyCommand;

export interface Seen {
    do: 'seen';
    step: number;
    format?: number;
}

/// Position of a device in the browser, in its own frame [mm].
export interface HapticPose {
    do: 'haptic_pose';
    position: Vec3;
    roll_deg?: number;
}

export interface Pose {
    do: 'tool';
    kind: 'endoscope' | 'sphere' | 'none';
    position: Vec3;
    direction: Vec3;
    up?: Vec3;
    radius?: number;
}

export interface BoxFrame {
    kind: 'box';
    step: number;
    volume: number;
    format: number; ///< 1: voxels [HU]; others: state/overlay_kinds.ts and below
    last: boolean; ///< last box of the step
    box: Box;
    halves: Uint16Array;
}

export interface Tool {
    client: number;
    kind: 'endoscope' | 'sphere';
    touches: boolean;
    limited: boolean;
    position: Vec3;
    direction: Vec3;
    up: Vec3;
    radius: number;
    force_n: Vec3; ///< on the tool; 0 if the tissue has no forces
    energy_per_mm: Vec3; ///< instead: energy per path [mm² · weight/mm]
    fraction: number;
}

export interface ToolsFrame {
    kind: 'tools';
    tools: Tool[];
}

/// Format of the rest field's boxes.
export const kRestFormat = 4;
/// Format of labels' boxes.
export const kLabelFormat = 5;
/// Format of a coarse scan's boxes, in every kCoarseStep-th voxel; the largest format.
export const kCoarseFormat = 6;
export const kCoarseStep = 4;

const kHeader = 32;
const kToolBytes = 80;
const kHalvesOfNode = 4; // in a box of the rest field

const littleEndian = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1;

/// Decodes a binary message. @throws an Error that names the invalid field
export function decodeFrame(
    buffer: ArrayBuffer,
): BoxFrame | ToolsFrame | SurfaceFrame | VesselFrame {
    const view = new DataView(buffer);
    if (buffer.byteLength < kHeader)
        throw new Error(`frame: ${buffer.byteLength} bytes, expected at least ${kHeader}`);
    if (view.getUint32(0) !== 0x504c4e54) throw new Error('frame: does not start with PLNT');
    const type = view.getUint8(4);
    const flags = view.getUint8(5);
    const payload = buffer.byteLength - kHeader;
    if (flags & 1) throw new Error('frame: packed with LZ4, which was not asked for');
    if (view.getUint32(28, true) !== payload)
        throw new Error(`frame: ${payload} bytes of payload, said ${view.getUint32(28, true)}`);
    if (type === 1) return decodeBox(view, (flags & 2) !== 0, payload);
    if (type === 2) return decodeTools(view, payload);
    if (type === 3) return decodeSurface(view, payload);
    if (type === 4) return decodeVessel(view, payload);
    throw new Error(`frame: type ${type}, expected 1…4`);
}

function decodeBox(view: DataView, last: boolean, payload: number): BoxFrame {
    const format = view.getUint16(6, true);
    if (format < 1 || format > kCoarseFormat)
        throw new Error(`box: format ${format}, expected 1…${kCoarseFormat}`);
    const u16 = (offset: number): number => view.getUint16(offset, true);
    const begin: Vec3 = [u16(16), u16(18), u16(20)];
    const count: Vec3 = [u16(22), u16(24), u16(26)];
    const each = format === kRestFormat ? kHalvesOfNode : 1;
    if (2 * each * count[0] * count[1] * count[2] !== payload || payload === 0)
        throw new Error(`box: ${payload} bytes for ${count.join('×')} half floats`);
    if (!littleEndian) throw new Error('this machine stores numbers with the high byte first');
    return {
        kind: 'box',
        step: view.getUint32(8, true),
        volume: view.getUint32(12, true),
        format,
        last,
        box: {
            begin,
            end: [begin[0] + count[0], begin[1] + count[1], begin[2] + count[2]],
        },
        halves: new Uint16Array(view.buffer as ArrayBuffer, kHeader, payload / 2),
    };
}

function decodeTools(view: DataView, payload: number): ToolsFrame {
    const count = view.getUint16(6, true);
    if (payload !== count * kToolBytes)
        throw new Error(`tools: ${payload} bytes for ${count} tools`);
    const tools: Tool[] = [];
    for (let i = 0; i < count; ++i) {
        const at = kHeader + i * kToolBytes;
        const vector = (offset: number): Vec3 => [
            view.getFloat32(at + offset, true),
            view.getFloat32(at + offset + 4, true),
            view.getFloat32(at + offset + 8, true),
        ];
        const flags = view.getUint8(at + 5);
        tools.push({
            client: view.getUint32(at, true),
            kind: view.getUint8(at + 4) === 1 ? 'endoscope' : 'sphere',
            touches: (flags & 1) !== 0,
            limited: (flags & 2) !== 0,
            position: vector(8),
            direction: vector(20),
            up: vector(32),
            radius: view.getFloat32(at + 44, true),
            force_n: vector(48),
            energy_per_mm: vector(60),
            fraction: view.getFloat32(at + 72, true),
        });
    }
    return { kind: 'tools', tools };
}

export const gridOf = (v: VolumeInfo): Grid => ({
    size: v.size,
    spacing: v.spacing_mm,
    origin: v.origin_mm,
    direction: v.direction,
});
