// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rounded limits: beside its box, a limit for how far an element may lag behind its neighbours
// taken together.
//
//   Σ_b ( max(0, w_b − w_j) / lag_b )² ≤ 1
//
// where w_b is the neighbour of j on axis b that leads by the larger share of its link's lag. It is
// the upwind discretisation of |∇w| ≤ 1 in a metric, as fast marching solves it [Sethian1996]: the
// iso-surfaces of a push are ellipsoids, where the box makes octahedra.
//
// An element that lags further already (after pushes to and fro, or a change of materials) may not
// get worse: its bound is what the sum was before the push. So the state before the push is valid,
// the least valid state above it exists, and pushing on in the same direction in one step or in
// many ends in the same place.
//
// The sum is evaluated with roundings that are monotone in every place: an exact difference, a
// product with a constant, a square, a sum of three in one order. So the update is a monotone map
// on integers, and its least fixed point is unique, whatever the order of the updates.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "chainmail/fixed_point.h"

namespace pliant {

/// The neighbours of one element, by side: −x, +x, −y, +y, −z, +z.
struct RoundedLinks {
    std::array<Fixed, 6> lag;     ///< how far the element may lag behind each
    std::array<double, 6> share;  ///< 1/lag; 0 where the link does not count

    void set(int side, Fixed link_lag) {
        const auto s = std::size_t(side);
        lag[s] = link_lag;
        // Rigid links are kept by the box alone; cut ones don't bind.
        share[s] = link_lag > 0 && link_lag < kMaxHalfLimit ? 1.0 / link_lag : 0.0;
    }
};

struct LagSum {
    double sum;
    double slope;  ///< of the sum, per unit of the element's place
};

/// The sum above for an element at v. @param w  places of the neighbours
inline LagSum lag_sum(const RoundedLinks& links, const std::array<Fixed, 6>& w, Fixed v) {
    LagSum result{0, 0};
    for (std::size_t low = 0; low < 6; low += 2) {
        const double a = (double(w[low]) - v) * links.share[low];
        const double b = (double(w[low + 1]) - v) * links.share[low + 1];
        const double t = std::max(0.0, std::max(a, b));
        result.sum += t * t;
        result.slope -= 2 * t * (a > b ? links.share[low] : links.share[low + 1]);
    }
    return result;
}

/// Least place at or above v with every link's lag kept and the sum within the bound. @pre bound ≥
/// 1
inline Fixed least_rounded_place(const RoundedLinks& links, const std::array<Fixed, 6>& w,
                                 double bound, Fixed v) {
    for (std::size_t s = 0; s < 6; ++s) v = std::max(v, w[s] - links.lag[s]);
    LagSum at = lag_sum(links, w, v);
    if (!(at.sum > bound)) return v;
    // Newton from the left on a convex, falling function: it never overshoots by more than
    // rounding.
    const Fixed lowest = v;
    constexpr int kMostSteps = 40;
    for (int n = 0; n < kMostSteps && at.sum > bound; ++n) {
        const double step = (at.sum - bound) / -at.slope;
        v += std::max(Fixed(1), Fixed(std::min(step, double(kMaxHalfLimit))));
        at = lag_sum(links, w, v);
    }
    while (lag_sum(links, w, v).sum > bound) ++v;
    while (v > lowest && !(lag_sum(links, w, v - 1).sum > bound)) --v;
    return v;
}

}  // namespace pliant
