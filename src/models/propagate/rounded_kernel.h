// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of rounded limits in two versions: plain, for any brick size, and with vector
// instructions. Both give the same bits.
//
// In addition to its box, an element j has a limit for its lag behind its neighbours together.
//
//   Σ_b ( max(0, w_b − w_j) / lag_b )² ≤ 1
//
// where w_b is the neighbour of j on axis b that leads by the larger share of its link's lag. It is
// the upwind discretisation of |∇w| ≤ 1 in a metric, as in fast marching [Sethian1996]: the
// iso-surfaces of a push are ellipsoids instead of the octahedra of the box.
//
// An element with a larger lag (after pushes to and fro, or a change of materials) must not get
// worse: its bound is the value of the sum before the push. So the state before the push is valid,
// the least valid state above it exists, and a motion in one direction ends in the same position in
// one step or in many.
//
// The sum is evaluated with roundings that are monotone in every position: an exact difference, a
// product with a constant, a square, a sum of three in one order. So the update is a monotone map
// on integers, and its least fixed point is unique, independent of the order of updates.

#pragma once

#include <array>

#include "propagate/sweep_kernels.h"

namespace pliant {

/// One component of a brick with the elements behind its faces. Values of a face are in the order
/// of sweep_kernels.h.
struct RoundedBrick {
    struct Face {
        /// Positions of the elements behind it; null: none of them leads. `start`: before the push.
        const Fixed* now = nullptr;
        const Fixed* start = nullptr;
        const Fixed* lag = nullptr;  ///< largest lag of the brick's elements behind them
        bool rose = false;           ///< elements behind it rose since the last visit
    };

    int size;
    Fixed* w;            ///< size³ positions; raised to the least fixed point above them
    const Fixed* start;  ///< before the push; null: all of them and all behind faces are at 0
    bool is_new;         ///< any element may be outside of its limits, not only those at `rose`
    InsideLags lags;     ///< of the links inside, each array by the link's lower element
    std::array<Face, 6> faces;
};
using RelaxRounded = void (*)(const RoundedBrick& brick);

/// Loops of a solve.
struct RoundedKernels {
    const SweepKernels& sweep;
    RelaxRounded relax;
};

/// Position of missing elements, behind all others.
inline constexpr Fixed kNeverLeads = -kUnlinked;

/// Share of a lag that one unit takes. Rigid links are satisfied by the box alone; cut ones don't
/// bind.
inline double share_of_unit(Fixed lag) {
    return lag > 0 && lag < kMaxHalfLimit ? 1.0 / lag : 0.0;
}

/// Plain loops, any size.
RelaxRounded plain_relax_rounded();
/// Vector instructions, the best that this processor supports. @pre size is 8
RelaxRounded vector_relax_rounded();

}  // namespace pliant
