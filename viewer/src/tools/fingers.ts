// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Two fingers on a view: their distance zooms, their middle pans. A single finger is a pointer like
// any other.

/// Position on the page [CSS pixels].
interface Point {
    readonly x: number;
    readonly y: number;
}

/// Motion of two fingers since the last one.
export interface Pinch {
    readonly factor: number; ///< of their distance
    readonly dx: number; ///< of their middle
    readonly dy: number;
    readonly middle: Point;
}

const kMinDistance = 10; // [pixels]

export class Fingers {
    private readonly touching = new Map<number, Point>();
    private both = false; // two have touched, and not all are lifted yet

    /// Tests whether fingers pinch, or did and are not all lifted yet.
    get pinch(): boolean {
        return this.both;
    }

    /// @returns whether this finger begins a pinch
    down({ pointerId, clientX: x, clientY: y }: PointerEvent): boolean {
        this.touching.set(pointerId, { x, y });
        const begins = this.touching.size === 2 && !this.both;
        this.both ||= begins;
        return begins;
    }

    move({ pointerId, clientX: x, clientY: y }: PointerEvent): Pinch | undefined {
        if (!this.touching.has(pointerId)) return undefined;
        const before = this.spread();
        this.touching.set(pointerId, { x, y });
        const after = this.spread();
        if (!before || !after) return undefined;
        const length = (spread: { distance: number }): number =>
            Math.max(spread.distance, kMinDistance);
        return {
            factor: length(after) / length(before),
            dx: after.middle.x - before.middle.x,
            dy: after.middle.y - before.middle.y,
            middle: after.middle,
        };
    }

    /// @returns whether the last finger of a pinch was lifted
    up({ pointerId }: PointerEvent): boolean {
        this.touching.delete(pointerId);
        const ends = this.both && this.touching.size === 0;
        if (ends) this.both = false;
        return ends;
    }

    private spread(): { distance: number; middle: Point } | undefined {
        const [a, b] = [...this.touching.values()];
        if (!this.both || !a || !b || this.touching.size !== 2) return undefined;
        return {
            distance: Math.hypot(a.x - b.x, a.y - b.y),
            middle: { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 },
        };
    }
}
