// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Outcomes of commands in a user's words, with the position of a bone that stopped a tool. They are
// shown at the tool and go away by themselves.

import { voxelFromWorld } from '../maths/grid.ts';
import { add, along, cross, mul, norm, normalized, sub, type Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';
import type { Answer, Done } from '../net/protocol.ts';
import type { Outcome, State } from '../state/state.ts';
import { lengthText, scaleOf } from '../state/units.ts';
import type { Store } from '../state/store.ts';

const kShowMs = 2500;
const kReach = 60; // of the search for a bone, in a body [mm]
const kDirections = 200;

/// Position and direction of a tool when a command was sent.
export interface Motion {
    readonly from: Vec3;
    readonly by: Vec3;
    readonly radius: number;
}

/// First position along a ray with at least a value.
function boneAlong(
    volume: VolumeData,
    from: Vec3,
    direction: Vec3,
    bone: number,
    reach: number,
): Vec3 | undefined {
    const step = 0.5 * Math.min(...volume.grid.spacing);
    for (let t = 0; t <= reach; t += step) {
        const place = along(from, t, direction);
        const value = volume.valueAt(voxelFromWorld(volume.grid, place));
        if (value !== undefined && value >= bone) return place;
    }
    return undefined;
}

/// Bone ahead of a tool, else the nearest one around it; undefined if there is none within reach.
/// @param scale  of lengths: 1 in a body
export function findBone(
    volume: VolumeData,
    { from, by }: Motion,
    bone: number,
    scale = 1,
): { place: Vec3; isAhead: boolean } | undefined {
    const farthest = scale * kReach;
    if (norm(by) > 0) {
        const ahead = normalized(by);
        // Tissue around the axis moves as well: a narrow cone.
        const side = normalized(cross(ahead, Math.abs(ahead[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0]));
        const other = cross(ahead, side);
        const found = [
            [0, 0],
            [0.3, 0],
            [-0.3, 0],
            [0, 0.3],
            [0, -0.3],
        ].map(([u, v]) => {
            const ray = normalized(add(ahead, add(mul(u!, side), mul(v!, other))));
            return boneAlong(volume, from, ray, bone, farthest);
        });
        const place = nearest(from, found);
        if (place) return { place, isAhead: true };
    }
    let best: Vec3 | undefined;
    for (let n = 0; n < kDirections; ++n) {
        // Evenly over the sphere, along a spiral.
        const z = 1 - (2 * n + 1) / kDirections;
        const angle = n * Math.PI * (3 - Math.sqrt(5));
        const r = Math.sqrt(1 - z * z);
        const ray: Vec3 = [r * Math.cos(angle), r * Math.sin(angle), z];
        const reach = best ? norm(sub(best, from)) : farthest;
        best = nearest(from, [best, boneAlong(volume, from, ray, bone, reach)]);
    }
    return best && { place: best, isAhead: false };
}

function nearest(from: Vec3, places: readonly (Vec3 | undefined)[]): Vec3 | undefined {
    let best: Vec3 | undefined;
    for (const place of places)
        if (place && (!best || norm(sub(place, from)) < norm(sub(best, from)))) best = place;
    return best;
}

/// Value above which tissue doesn't move [HU].
const boneValue = ({ shared }: State): number =>
    (shared?.tissue?.model === 'springs' ? shared.tissue.fixed_hu : undefined) ??
    shared?.materials.bone_threshold_hu ??
    300;

/// Outcome of a command; null: it went as wished.
export function outcomeOf(
    done: Done,
    state: State,
    volume: VolumeData | undefined,
    motion: Motion | undefined,
): Outcome | null {
    const place = motion?.from ?? state.sections.cursor;
    const plain = (text: string): Outcome => ({ text, place, obstacle: null, isStopped: false });
    if (done.cut_links !== undefined)
        return plain(done.cut_links ? `cut: ${done.cut_links} links` : 'no tissue here');
    // A sphere that touches nothing moves freely.
    if (done.grabbed_elements === 0 && done.limited_by !== 'bone')
        return done.do === 'grab' ? plain('no tissue here') : null;
    if (done.status === undefined || done.status === 'applied') return null;
    const stopped = (text: string, obstacle: Vec3 | null = null): Outcome => ({
        text,
        place,
        obstacle,
        isStopped: true,
    });
    switch (done.limited_by) {
        case 'bone': {
            const scale = scaleOf(state.scan.volume);
            const found = volume && motion && findBone(volume, motion, boneValue(state), scale);
            if (!found) return stopped('stopped by bone');
            const gap = Math.max(norm(sub(found.place, place)) - motion.radius, 0);
            const where = found.isAhead ? 'behind' : 'away';
            const far = lengthText(state.scan.volume, gap, 1);
            return stopped(`stopped by bone, ${far} mm ${where}`, found.place);
        }
        case 'movement':
            return stopped('stopped: this tissue gives no more');
        case 'wall':
            return stopped('stopped by the wall');
        case 'fold':
            return stopped('stopped: the tissue would fold');
        default:
            return stopped(done.message || 'stopped');
    }
}

export class Outcomes {
    private fading = 0;

    constructor(
        private readonly store: Store,
        private readonly volume: () => VolumeData | undefined,
    ) {}

    /// Shows the outcome of a command; one that went as wished takes the last away.
    take(answer: Answer | undefined, motion?: Motion): void {
        if (answer?.t !== 'done') return;
        this.show(outcomeOf(answer, this.store.state, this.volume(), motion));
    }

    show(outcome: Outcome | null): void {
        clearTimeout(this.fading);
        this.store.set({ tool: { outcome } });
        if (outcome) this.fading = setTimeout(() => this.show(null), kShowMs) as unknown as number;
    }
}
