// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The wall as it was when a scoop was set on it. A scoop that followed the wall of the moment would
// bore into the hole that it has just made; one that follows this wall keeps its depth.

import { voxelFromWorld } from '../maths/grid.ts';
import { along, type Vec3 } from '../maths/vec.ts';
import type { VolumeData } from '../maths/volume.ts';
import type { State } from '../state/state.ts';
import { type SectionPlane, worldOfPixel } from '../views/section_geometry.ts';
import { planeAt, rayAt, type Spot, surfaceAt } from './aim.ts';

const kReach = 40; // of the copy around the first position [mm]
const kMaxVoxels = 4e6;

export class CarveWall {
    private readonly copy: VolumeData;
    private readonly plane: SectionPlane | undefined;
    depth = 0; ///< of the scoop below the wall [mm]

    constructor(
        private readonly volume: VolumeData,
        state: State,
        start: Spot,
        place: Vec3,
    ) {
        const { grid } = volume;
        this.plane = planeAt(volume, state, start);
        const edge = Math.cbrt(kMaxVoxels * grid.spacing.reduce((product, s) => product * s, 1));
        const reach = Math.min(kReach, edge / 2);
        const middle = voxelFromWorld(grid, place);
        const half = [0, 1, 2].map((a) => reach / grid.spacing[a]!);
        const begin = middle.map((m, a) => Math.max(Math.floor(m - half[a]!), 0));
        const end = middle.map((m, a) => Math.min(Math.ceil(m + half[a]!), grid.size[a]!));
        const box = { begin: begin as unknown as Vec3, end: end as unknown as Vec3 };
        this.copy = volume.copyOf(box);
    }

    /// Position of the scoop under a spot; undefined if there is no wall.
    at(state: State, spot: Spot): Vec3 | undefined {
        if (this.plane)
            return along(
                worldOfPixel(this.plane, spot.x, spot.y),
                this.depth,
                this.plane.axes.normal,
            );
        const { origin, direction } = rayAt(state, spot);
        const then = surfaceAt(this.copy, state, origin, direction);
        const now = surfaceAt(this.volume, state, origin, direction);
        // The wall of the moment counts where there is no copy, also in front of the copied one.
        const isBeyond = now !== undefined && !this.holds(now.point);
        const inFront = isBeyond && (!then || now.distance < then.distance);
        const hit = inFront ? now : then;
        return hit && along(hit.point, this.depth, direction);
    }

    private holds(place: Vec3): boolean {
        const { grid } = this.copy;
        return voxelFromWorld(grid, place).every((x, a) => x >= 0 && x <= grid.size[a]! - 1);
    }
}
