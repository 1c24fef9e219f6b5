// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The minimal move, one component of the displacement at a time.
//
// For a push along +a work with w = u_a, for one along −a with w = −u_a, so that moving is always
// raising. Each link says how far one end may lag behind the other: w_j ≥ w_i − lag(i, j). Raise
// the grabbed elements by the length of the push; the least feasible w above is then a longest
// path,
//
//   w_j = max( w_j, max over neighbours i of (w_i − lag(i, j)) ),
//
// with a unique fixed point, whatever the order of the updates. The amount that j is raised is the
// amount of the push minus the slack on the way there, so the smaller push f·δ needs no new solve:
// each element is raised by max(0, raise − (1 − f)·δ).
//
// Both solvers leave w in Brick::raised[axis] for every brick with reached[axis].

#pragma once

#include <pliant/tasks.h>

#include <span>

#include "chainmail/lattice.h"

namespace pliant {

/// One component of a push.
struct ComponentPush {
    int axis;      ///< 0, 1, 2: along i, j, k
    int sign;      ///< +1 or −1
    Fixed amount;  ///< > 0
};

/// What a value contributes to the lag along link axis b: forward, how far the upper end may lag
/// behind the lower one; backward, the other way round.
inline Fixed half_lag_forward(const HalfLimits& half, const ComponentPush& push, int b) {
    if (b != push.axis) return half.shear[b];
    return push.sign > 0 ? half.compress[b] : half.stretch[b];
}
inline Fixed half_lag_backward(const HalfLimits& half, const ComponentPush& push, int b) {
    if (b != push.axis) return half.shear[b];
    return push.sign > 0 ? half.stretch[b] : half.compress[b];
}

/// How far the neighbour of an element on a side (0…5: −x, +x, −y, …) may lag behind the element.
/// Links that are outside of their limits already (see Lattice::may_exceed_limits) may not get
/// worse.
Fixed link_lag(const Lattice& lattice, Vec3i element, int side, const ComponentPush& push);

/// Marks a brick as reached, with every element where it was before the push.
void begin_raise(const Lattice& lattice, Brick& brick, const ComponentPush& push);

/// Brick-wise: each brick is swept to its own fixed point, then wakes the neighbours that its faces
/// raise. Bricks with the largest pending raise go first; bricks of one chessboard colour go in
/// parallel, since they share no face.
/// @pre every grabbed element has a brick
/// @returns false if more than max_bricks would be needed; then the raise is incomplete
[[nodiscard]] bool propagate_by_sweeps(Lattice& lattice, std::span<const ElementRef> grabbed,
                                       const ComponentPush& push, const TaskArena& arena,
                                       int max_bricks);

/// Ordered propagation with a heap: the element with the largest raise is final, and goes next
/// (Enhanced ChainMail [Schill1998] with the order that makes it exact: per component, by raise
/// instead of by violation; a shortest-path search [Dijkstra1959]).
[[nodiscard]] bool propagate_by_heap(Lattice& lattice, std::span<const ElementRef> grabbed,
                                     const ComponentPush& push, int max_bricks);

/// The least raise under rounded limits (rounded.h).
[[nodiscard]] bool propagate_rounded(Lattice& lattice, std::span<const ElementRef> grabbed,
                                     const ComponentPush& push, const TaskArena& arena,
                                     int max_bricks);

}  // namespace pliant
