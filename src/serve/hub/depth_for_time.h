// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The depth of forces that the time at hand allows [Choi2004, 5].

#pragma once

#include <algorithm>
#include <cmath>

namespace pliant::serve {

inline constexpr int kFewestLayers = 1, kMostLayers = 20;

/// Depth for the next half second. The nodes within a depth grow with its cube, so a motion that
/// falls behind loses layers by the cube root of its pace; one that has time to spare gains one at
/// a time, and only if that leaves some.
/// @param pace  simulated over real time, at most about 1
/// @param load  computing time over simulated time
inline int depth_for_time(int depth, double pace, double load) {
    constexpr double kSlow = 0.95, kSpare = 0.7;
    if (pace < kSlow) {
        const int lower = int(std::floor(depth * std::cbrt(std::max(0.0, pace))));
        return std::max(std::min(lower, depth - 1), std::min(depth, kFewestLayers));
    }
    const double next = load * std::pow((depth + 1.0) / std::max(1, depth), 3);
    return next < kSpare && depth < kMostLayers ? depth + 1 : depth;
}

}  // namespace pliant::serve
