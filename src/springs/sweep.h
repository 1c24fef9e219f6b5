// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loop of a step: eight nodes at a time, their links one slot after the other.
//
//   S = Σ (k·l/|r| − k) r − (c/h) (n·Δ) n,   r = x_i − x_j,  Δ = (x_i − x_i⁻) − (x_j − x_j⁻)
//   x⁺ = x + c1·(x − x⁻) + c2·(F + S)
//   c2 = 1/(m/h² + d/2h),  c1 = (m/h² − d/2h)·c2;  both 0 for nodes that don't move
//
// which is [Choi2004, Eq. 5, 7, 8] in another form. 1/|r| comes from the bits of |r|², with
// multiplications and additions only: faster than a root and a division, and the same on every
// machine. Multiplications and additions are fused where they are written so.

#pragma once

#include "springs/sweep_plan.h"

namespace pliant {

/// 1/√q: a guess from half the exponent leaves e = 1 − q·y² within ±0.07. The polynomial in e with
/// the least relative error there leaves 5·10⁻⁵, and the series 1 + e/2 + 3/8·e² + 5/16·e³ then
/// nothing but rounding.
inline constexpr std::uint64_t kRootGuess = 0x5FE6EB50C7B537A9ULL;
inline constexpr double kRoot0 = 1.000000215158619, kRoot1 = 0.501095861521234,
                        kRoot2 = 0.3755006002939137;

/// All by local number.
struct SweepArrays {
    const double *x[3], *before[3];
    double* next[3];
    const double *force[3], *keep, *push;  ///< F, c1, c2
};

/// Packs begin…end of a plan. @param farthest2  square of the longest move that is believed
/// @returns whether all moves were shorter
using SweepKernel = bool (*)(const SweepPlan& plan, const SweepArrays& arrays, std::int64_t begin,
                             std::int64_t end, double farthest2);

SweepKernel plain_sweep();
/// The best that this processor has; plain_sweep() without fused multiplication and addition.
SweepKernel vector_sweep();

}  // namespace pliant
