// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The depth of springs that fits the time of an update.
// Covers: hub/sweep_pace.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hub/traffic.h"

namespace pliant::serve {
namespace {

/// Depth that is kept on a machine which computes `cost` · depth³ ms in a millisecond.
int settled_depth(double cost, int depth) {
    for (int window = 0; window < 60; ++window) {
        const double load = cost * std::pow(depth, 3);
        depth = depth_for_time(depth, std::min(1.0, 1 / load), load);
    }
    return depth;
}

TEST(DepthForTime, EndsAtTheDeepestLayersThatLeaveTimeToSpareFromBothSides) {
    for (const double cost : {1e-5, 1e-3, 4e-3, 0.02, 0.1}) {
        for (const int start : {1, 5, 20, 60}) {
            const int depth = settled_depth(cost, start);
            EXPECT_LE(cost * std::pow(depth, 3), 1 / 0.95) << cost << " from " << start;
            if (depth < kMostLayers) {
                EXPECT_GE(cost * std::pow(depth + 1, 3), 0.7) << cost << " from " << start;
            }
            EXPECT_EQ(depth_for_time(depth, 1, cost * std::pow(depth, 3)), depth);
        }
    }
}

TEST(DepthForTime, OneLayerIsTheLeast) {
    EXPECT_EQ(settled_depth(100, 20), kFewestLayers);
    EXPECT_EQ(depth_for_time(1, 0, 100), 1);
    EXPECT_EQ(depth_for_time(0, 0.1, 10), 0);
}

}  // namespace
}  // namespace pliant::serve
