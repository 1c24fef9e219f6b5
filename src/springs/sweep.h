// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loop of a step: eight nodes at a time, their links one slot after the other.
//
//   S = Σ (k·l/|r| − k) r − (c/h) (n·Δ) n,   r = x_i − x_j,  Δ = (x_i − x_i⁻) − (x_j − x_j⁻)
//   x⁺ = x + c1·(x − x⁻) + c2·(F + S)
//   c2 = 1/(m/h² + d/2h),  c1 = (m/h² − d/2h)·c2;  both 0 for nodes that don't move
//
// which is [Choi2004, Eq. 5, 7, 8] in another form. 1/|r| comes from Newton's method on the bits of
// |r|², with multiplications and additions only: three times as fast as a root and a division, and
// the same on every machine. Multiplications and additions are fused where they are written so.

#pragma once

#include "springs/sweep_plan.h"

namespace pliant {

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
