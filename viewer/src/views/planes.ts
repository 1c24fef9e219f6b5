// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pictures in the endoscope's view: one, or the two planes of fluoroscopy. Biplane systems have two
// sources with detectors, 90° apart: a single projection shows no depth.

import type { State, View } from '../state/state.ts';
import { orbitTurned } from './orbit.ts';
import type { Extent } from './projection.ts';

/// A picture in a rectangle of the view, in the view's pixels from its top left corner.
export interface PlaneOfView extends Extent {
    readonly view: View;
    readonly x: number;
    readonly y: number;
}

export const hasTwoPlanes = ({ view, fluoro }: State): boolean =>
    view.outside && view.fluoroscopy && fluoro.biplane;

/// Pictures of the endoscope's view. The second plane is turned about the picture's vertical axis;
/// it is beside the first, in high views below it.
export function planesOf(state: State, { width, height }: Extent): readonly PlaneOfView[] {
    const { view } = state;
    if (!hasTwoPlanes(state)) return [{ view, x: 0, y: 0, width, height }];
    const turned = { ...view, orbit: orbitTurned(view.orbit, Math.PI / 2, 0) };
    const beside = width >= height;
    const size = beside
        ? { width: Math.ceil(width / 2), height }
        : { width, height: Math.ceil(height / 2) };
    return [
        { view, x: 0, y: 0, ...size },
        { view: turned, x: width - size.width, y: height - size.height, ...size },
    ];
}

/// Picture under a position of the view, and the position in it.
export function planeUnder<T extends Extent & { readonly x: number; readonly y: number }>(
    state: State,
    spot: T,
): { view: View; spot: T } {
    const planes = planesOf(state, spot);
    const isIn = ({ x, y }: PlaneOfView): boolean => spot.x >= x && spot.y >= y;
    const { view, x, y, width, height } = [...planes].reverse().find(isIn) ?? planes[0]!;
    return { view, spot: { ...spot, x: spot.x - x, y: spot.y - y, width, height } };
}
