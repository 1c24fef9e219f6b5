// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mock of a scene for tests of the page alone: a bent tube of air in a block, deformed by smooth
// bumps, without ChainMail. It keeps the promises of the protocol: boxes have all changes, and undo
// restores every bit.

import {
    type Box,
    type Grid,
    voxelCount,
    voxelFromWorld,
    worldFromVoxel,
} from '../src/maths/grid.ts';
import { halfOfFloat } from '../src/maths/half.ts';
import { murmur32 } from '../src/maths/murmur.ts';
import { along, cross, dot, norm, sub, type Vec3 } from '../src/maths/vec.ts';

export const kGrid: Grid = {
    size: [72, 64, 80],
    spacing: [1, 1, 1.25],
    origin: [-36, -32, -50],
    direction: [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
    ],
};

/// Centre of the tube at a height [mm].
export const tubeCentre = (z: number): Vec3 => [6 * Math.sin(z / 25), 4 * Math.cos(z / 30), z];
export const kTubeRadius = 9;

const original = (x: Vec3): number => {
    const off = norm(sub(x, tubeCentre(x[2])));
    const wall = Math.min(Math.max((off - kTubeRadius) / 1.5, 0), 1);
    const texture = 25 * Math.sin(x[0] / 2.1) * Math.sin(x[1] / 2.7) * Math.sin(x[2] / 3.3);
    const bone = norm(sub(x, [0, 24, x[2]])) < 5 ? 700 : 0;
    return -1000 + wall * (1040 + texture + bone);
};

interface Snapshot {
    name: string;
    warp: Float32Array;
    gone: Uint8Array;
    iso: number;
    polarity: 'rising' | 'falling';
    materials: Record<string, number | boolean | string>;
    stroke: string;
}

export class MockScene {
    readonly halves = new Uint16Array(voxelCount(kGrid));
    step = 1;
    iso = -500;
    polarity: 'rising' | 'falling' = 'rising';
    materials: Record<string, number | boolean | string> = {
        offset: 0.2,
        max_movement_mm: 20,
        bone_threshold_hu: 300,
        air_enabled: true,
        air_threshold_hu: -500,
        yield: 0,
        limits: 'box',
    };
    readonly undoSteps: Snapshot[] = [];
    redoSteps: Snapshot[] = [];
    /// Labels at rest: name of the file, values in use, and the number of each voxel.
    labels:
        { name: string; values: number[]; names: Map<number, string>; at: Uint8Array } | undefined;
    onChange: (box: Box) => void = () => {};
    /// Offset from each voxel to the position whose value it shows [mm].
    private warp: Float32Array = new Float32Array(3 * voxelCount(kGrid));
    private gone: Uint8Array = new Uint8Array(voxelCount(kGrid));
    private grabbed: { point: Vec3; radius: number; offset: Vec3 } | undefined;

    constructor() {
        this.fill({ begin: [0, 0, 0], end: kGrid.size });
    }

    checksum(): string {
        return murmur32(new Uint8Array(this.halves.buffer)).toString(16).padStart(8, '0');
    }

    /// Value of an overlay at a voxel: displacement [mm], or volume change.
    overlayAt(kind: string, index: number): number {
        const { warp } = this;
        if (kind === 'displacement')
            return Math.hypot(warp[3 * index]!, warp[3 * index + 1]!, warp[3 * index + 2]!);
        const [nx, ny, nz] = kGrid.size;
        const steps = [1, nx, nx * ny];
        const place = [index % nx, Math.floor(index / nx) % ny, Math.floor(index / (nx * ny))];
        if (place.some((p, a) => p === 0 || p === [nx, ny, nz][a]! - 1)) return 1;
        // The warp is the inverse deformation.
        const column = (a: number): Vec3 =>
            [0, 1, 2].map(
                (c) =>
                    (c === a ? 1 : 0) +
                    (warp[3 * (index + steps[a]!) + c]! - warp[3 * (index - steps[a]!) + c]!) /
                        (2 * kGrid.spacing[a]!),
            ) as unknown as Vec3;
        return 1 / dot(column(0), cross(column(1), column(2)));
    }

    /// Four values of the rest field at a voxel.
    restAt(index: number): number[] {
        const back = [0, 1, 2].map((a) => this.warp[3 * index + a]!);
        return [...back.map((x) => 0 - x), this.gone[index] ? 1 : 0];
    }

    /// Reads a raw NRRD file of bytes on this grid.
    readLabels(name: string, file: Buffer): string | undefined {
        const end = file.indexOf('\n\n');
        const head = file.subarray(0, end).toString('latin1');
        const bytes = file.subarray(end + 2);
        if (!head.startsWith('NRRD') || bytes.length !== voxelCount(kGrid))
            return `${name}: expected a label map`;
        const values = [...new Set(bytes)].filter((v) => v > 0).sort((a, b) => a - b);
        const names = new Map<number, string>();
        for (const [, n, value] of head.matchAll(/^Segment(\d+)_LabelValue:=(\d+)$/gm))
            names.set(
                Number(value),
                new RegExp(`^Segment${n}_Name:=(.*)$`, 'm').exec(head)?.[1] ?? '',
            );
        const at = Uint8Array.from(bytes, (v) => values.indexOf(v) + 1);
        this.labels = { name, values, names, at };
        return undefined;
    }

    /// Number of the label that a voxel shows.
    labelAt(index: number): number {
        if (!this.labels || this.gone[index]) return 0;
        const [nx, ny] = kGrid.size;
        const p = [index % nx, Math.floor(index / nx) % ny, Math.floor(index / (nx * ny))];
        const from = p.map((x, a) => Math.round(x + this.warp[3 * index + a]! / kGrid.spacing[a]!));
        if (from.some((x, a) => x < 0 || x >= kGrid.size[a]!)) return 0;
        return this.labels.at[from[0]! + nx * (from[1]! + ny * from[2]!)]!;
    }

    remember(name: string, stroke: string): void {
        const last = this.undoSteps[this.undoSteps.length - 1];
        if (stroke && last?.stroke === stroke) return;
        this.undoSteps.push(this.snapshot(name, stroke));
        this.redoSteps = [];
    }

    back(from: Snapshot[], to: Snapshot[]): boolean {
        const step = from.pop();
        if (!step) return false;
        to.push(this.snapshot(step.name, step.stroke));
        this.warp = step.warp;
        this.gone = step.gone;
        this.iso = step.iso;
        this.polarity = step.polarity;
        this.materials = step.materials;
        this.changed({ begin: [0, 0, 0], end: kGrid.size });
        return true;
    }

    /// Moves everything within three radii, with weights that fall with the distance.
    push(point: Vec3, motion: Vec3, radius: number): void {
        const reach = 3 * radius + norm(motion);
        const box = this.boxAround(point, point, reach);
        this.forEach(box, (x, i) => {
            const share = Math.max(1 - norm(sub(x, point)) / reach, 0) ** 2;
            for (let a = 0; a < 3; ++a) this.warp[3 * i + a]! -= share * motion[a]!;
        });
        this.changed(box);
    }

    carve(from: Vec3, to: Vec3, radius: number): number {
        const way = sub(to, from);
        const length2 = Math.max(dot(way, way), 1e-9);
        const box = this.boxAround(from, to, radius);
        let carved = 0;
        this.forEach(box, (x, i) => {
            const s = Math.min(Math.max(dot(sub(x, from), way) / length2, 0), 1);
            if (norm(sub(x, along(from, s, way))) > radius || this.gone[i]) return;
            this.gone[i] = 1;
            ++carved;
        });
        this.changed(box);
        return carved;
    }

    cut(line: readonly Vec3[], depth: Vec3): number {
        let cut = 0;
        for (let i = 0; i + 1 < line.length; ++i) {
            const steps = Math.ceil(norm(sub(line[i + 1]!, line[i]!)) / 0.7);
            for (let s = 0; s <= steps; ++s) {
                const at = along(line[i]!, s / steps, sub(line[i + 1]!, line[i]!));
                cut += this.carve(at, along(at, 1, depth), 0.75);
            }
        }
        return cut;
    }

    grab(point: Vec3, radius: number): void {
        this.remember('drag', `drag${this.step}`);
        this.grabbed = { point, radius: Math.max(radius, 1), offset: [0, 0, 0] };
    }
    drag(offset: Vec3): boolean {
        if (!this.grabbed) return false;
        const { point, radius } = this.grabbed;
        this.push(point, sub(offset, this.grabbed.offset), radius);
        this.grabbed.offset = offset;
        return true;
    }
    letGo(): void {
        this.grabbed = undefined;
    }

    reset(): void {
        this.warp = new Float32Array(this.warp.length);
        this.gone = new Uint8Array(this.gone.length);
        this.changed({ begin: [0, 0, 0], end: kGrid.size });
    }

    private snapshot(name: string, stroke: string): Snapshot {
        const { warp, gone, iso, polarity, materials } = this;
        return {
            name,
            warp: warp.slice(),
            gone: gone.slice(),
            iso,
            polarity,
            materials: { ...materials },
            stroke,
        };
    }

    private changed(box: Box): void {
        this.fill(box);
        ++this.step;
        this.onChange(box);
    }

    private fill(box: Box): void {
        this.forEach(box, (x, i) => {
            const from = along(x, 1, [
                this.warp[3 * i]!,
                this.warp[3 * i + 1]!,
                this.warp[3 * i + 2]!,
            ]);
            this.halves[i] = halfOfFloat(this.gone[i] ? -1000 : Math.round(original(from)));
        });
    }

    private boxAround(a: Vec3, b: Vec3, reach: number): Box {
        const low = voxelFromWorld(
            kGrid,
            along(
                [0, 1, 2].map((i) => Math.min(a[i]!, b[i]!)) as unknown as Vec3,
                -reach,
                [1, 1, 1],
            ),
        );
        const high = voxelFromWorld(
            kGrid,
            along(
                [0, 1, 2].map((i) => Math.max(a[i]!, b[i]!)) as unknown as Vec3,
                reach,
                [1, 1, 1],
            ),
        );
        const kept = (v: number, axis: number): number =>
            Math.min(Math.max(v, 0), kGrid.size[axis]!);
        return {
            begin: low.map((v, i) => kept(Math.floor(v), i)) as unknown as Vec3,
            end: high.map((v, i) => kept(Math.ceil(v) + 1, i)) as unknown as Vec3,
        };
    }

    private forEach(box: Box, body: (x: Vec3, index: number) => void): void {
        const [nx, ny] = kGrid.size;
        for (let k = box.begin[2]; k < box.end[2]; ++k)
            for (let j = box.begin[1]; j < box.end[1]; ++j)
                for (let i = box.begin[0]; i < box.end[0]; ++i)
                    body(worldFromVoxel(kGrid, [i, j, k]), i + nx * (j + ny * k));
    }
}
