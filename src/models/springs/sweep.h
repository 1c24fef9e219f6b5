// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loop of a step: eight nodes at a time, their links slot by slot.
//
//   S = Σ (k·l/|r| − k) r − (c/h) (n·Δ) n,   r = x_i − x_j,  Δ = (x_i − x_i⁻) − (x_j − x_j⁻)
//   x⁺ = x + c1·(x − x⁻) + c2·(F + S)
//   c2 = 1/(m/h² + d/2h),  c1 = (m/h² − d/2h)·c2;  both 0 for nodes that don't move
//
// which is [Choi2004, Eq. 5, 7, 8] in another form. A Maxwell branch subtracts q/|r| r, with q and
// its state as in state.h; both ends of a link have a copy of the state, with the same bits.
//
// 1/|r| is computed from the bits of |r|² by multiplications and additions only: faster than a root
// and a division, and identical on every machine. Multiplications and additions are fused only
// where written so.

#pragma once

#include "springs/sweep_plan.h"

namespace pliant {

/// 1/√q: an initial guess from half the exponent gives e = 1 − q·y² within ±0.07. The minimax
/// polynomial in e reduces the relative error to 5·10⁻⁵, and the series 1 + e/2 + 3/8·e² + 5/16·e³
/// then reduces it to rounding.
inline constexpr std::uint64_t kRootGuess = 0x5FE6EB50C7B537A9ULL;
inline constexpr double kRoot0 = 1.000000215158619, kRoot1 = 0.501095861521234,
                        kRoot2 = 0.3755006002939137;

/// All arrays are indexed by local number.
struct SweepArrays {
    const double *x[3], *before[3];
    double* next[3];
    const double *force[3], *keep, *push;  ///< F, c1, c2
    const double* branch;                  ///< [8 · slot + lane] s of MaxwellBranch
    double* next_branch;
};

/// Processes packs begin…end of a plan. @param farthest2  square of the longest valid move
/// @returns whether all moves were shorter
using SweepKernel = bool (*)(const SweepPlan& plan, const SweepArrays& arrays, std::int64_t begin,
                             std::int64_t end, double farthest2);

SweepKernel plain_sweep();
/// Kernel for the best instruction set of this processor; plain_sweep() without fused multiply-add.
SweepKernel vector_sweep();

}  // namespace pliant
