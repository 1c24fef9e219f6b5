// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Camera of the outside view: it looks at a centre from a distance, and turns about it.

import type { Camera } from '../maths/rays.ts';
import { along, cross, normalized, turned } from '../maths/vec.ts';
import type { Orbit, View } from '../state/state.ts';

export const kOutsideField = 30; ///< field of view [degrees]

/// Camera of the outside view.
export function orbitCamera({ orbit }: View): Camera {
    const { centre, direction, up, distance } = orbit;
    return { eye: along(centre, -distance, direction), look: direction, up };
}

/// Turns the outside view about its own axes [radians].
export function orbitTurned(orbit: Orbit, yaw: number, pitch: number): Orbit {
    const right = normalized(cross(orbit.direction, orbit.up));
    const side = turned(right, orbit.up, yaw);
    const direction = normalized(turned(turned(orbit.direction, orbit.up, yaw), side, pitch));
    return { ...orbit, direction, up: cross(side, direction) };
}
