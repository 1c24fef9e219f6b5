// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rounded limits: in addition to its box, a limit for the lag of an element behind its neighbours
// taken together.
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

#include <pliant/core/vec.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "material/limit_units.h"

namespace pliant {

/// The neighbours of one element, by side: −x, +x, −y, +y, −z, +z.
struct RoundedLinks {
    std::array<Fixed, 6> lag;     ///< largest lag of the element behind each
    std::array<double, 6> share;  ///< 1/lag; 0 where the link does not count

    void set(int side, Fixed link_lag) {
        const auto s = std::size_t(side);
        lag[s] = link_lag;
        // Rigid links are satisfied by the box alone; cut ones don't bind.
        share[s] = link_lag > 0 && link_lag < kMaxHalfLimit ? 1.0 / link_lag : 0.0;
    }
};

/// Shares of lag on each axis, before squaring, for an element at v.
inline Vec3d lag_shares(const RoundedLinks& links, const std::array<Fixed, 6>& w, Fixed v) {
    Vec3d shares{};
    for (int b = 0; b < 3; ++b) {
        const auto low = std::size_t(2 * b), high = low + 1;
        const double below = (double(w[low]) - v) * links.share[low];
        const double above = (double(w[high]) - v) * links.share[high];
        shares[b] = std::max(0.0, std::max(below, above));
    }
    return shares;
}

inline double lag_sum(const RoundedLinks& links, const std::array<Fixed, 6>& w, Fixed v) {
    const Vec3d t = lag_shares(links, w, v);
    return t.x * t.x + t.y * t.y + t.z * t.z;
}

/// Lower bound of the rise from v at which the sum falls to the bound: the root of
/// Σ (t_b − q_b·x)² = bound over the axes that still contribute there. Neighbours that become the
/// largest of their axis on the way are ignored, so it may fall short.
/// @pre the sum at v is above the bound
inline double rounded_rise(const RoundedLinks& links, const std::array<Fixed, 6>& w, double bound,
                           Fixed v) {
    const Vec3d t = lag_shares(links, w, v);
    Vec3d q{};
    for (int b = 0; b < 3; ++b) {
        const auto low = std::size_t(2 * b), high = low + 1;
        const bool is_low = (double(w[low]) - v) * links.share[low] == t[b];
        q[b] = t[b] > 0 ? links.share[is_low ? low : high] : 0;
    }
    for (;;) {
        double qq = 0, qt = 0, tt = 0;
        int nearest = -1;  // the axis that ceases to contribute first
        for (int b = 0; b < 3; ++b) {
            if (q[b] == 0) continue;
            qq += q[b] * q[b];
            qt += q[b] * t[b];
            tt += t[b] * t[b];
            if (nearest < 0 || t[b] * q[nearest] < t[nearest] * q[b]) nearest = b;
        }
        const double under_root = qt * qt - qq * (tt - bound);
        const double rise =
            under_root >= 0 ? (tt - bound) / (qt + std::sqrt(under_root)) : HUGE_VAL;
        if (nearest < 0 || rise * q[nearest] <= t[nearest]) return nearest < 0 ? 0 : rise;
        q[nearest] = 0;
    }
}

/// Least position at or above v that satisfies every link's lag and the bound of the sum.
/// @pre bound ≥ 1
inline Fixed least_rounded_position(const RoundedLinks& links, const std::array<Fixed, 6>& w,
                                    double bound, Fixed v) {
    for (std::size_t s = 0; s < 6; ++s) v = std::max(v, w[s] - links.lag[s]);
    if (!(lag_sum(links, w, v) > bound)) return v;
    const Fixed lowest = v;
    do {
        const double rise = rounded_rise(links, w, bound, v);
        v += std::max(Fixed(1), Fixed(std::min(rise, double(kMaxHalfLimit))));
    } while (lag_sum(links, w, v) > bound);
    // The guess is only a start: the result is the crossing of the sum itself.
    while (v > lowest && !(lag_sum(links, w, v - 1) > bound)) --v;
    return v;
}

}  // namespace pliant
