// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Own cuts, to be marked: a cut that nothing holds open changes no voxel. A mark goes when its cut
// is undone.

import { add, along, dot, sub, type Vec3 } from '../maths/vec.ts';
import type { CutMark } from '../state/state.ts';
import type { Store } from '../state/store.ts';

export class Cuts {
    constructor(private readonly store: Store) {
        store.watch(
            ({ shared }) => [shared?.undo.steps ?? 0],
            (steps) => {
                const { cuts } = store.state.tool;
                const left = cuts.filter((cut) => cut.steps <= steps);
                if (left.length < cuts.length) store.set({ tool: { cuts: left } });
            },
        );
    }

    /// Number of the server's steps with the next command.
    get nextStep(): number {
        return (this.store.state.shared?.undo.steps ?? 0) + 1;
    }

    add(cut: CutMark): void {
        this.store.set({ tool: { cuts: [...this.store.state.tool.cuts, cut] } });
    }
}

/// Segments in which the surface of a cut crosses a plane.
export function cutCrossings({ line, depth }: CutMark, centre: Vec3, normal: Vec3): [Vec3, Vec3][] {
    const segments: [Vec3, Vec3][] = [];
    const height = (p: Vec3): number => dot(sub(p, centre), normal);
    for (let i = 1; i < line.length; ++i) {
        const [a, b] = [line[i - 1]!, line[i]!];
        const corners = [a, b, add(b, depth), add(a, depth)];
        const found: Vec3[] = [];
        for (const [n, from] of corners.entries()) {
            const to = corners[(n + 1) % 4]!;
            const [low, high] = [height(from), height(to)];
            if (low < 0 === high < 0) continue;
            found.push(along(from, low / (low - high), sub(to, from)));
        }
        if (found.length >= 2) segments.push([found[0]!, found[1]!]);
    }
    return segments;
}
