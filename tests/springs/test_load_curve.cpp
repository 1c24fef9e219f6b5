// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The load curve of a bar with wavy fibres bends as that of tissue [Choi2004, Fig. 11c].
// Covers: springs/builders_lattice.cpp, springs/tissue.cpp.

#include <gtest/gtest.h>

#include "crimp.h"
#include "support/made.h"

namespace pliant::test {
namespace {

std::vector<results::LoadPoint> curve_of(double shift) {
    SpringTissue bar = made(results::crimped_bar(shift));
    return made(results::load_curve(bar, 40));
}

TEST(LoadCurve, OfWavyFibresIsAJ) {
    const auto curve = curve_of(1.5);
    const double first = results::slope_at(curve, 0),
                 last = results::slope_at(curve, curve.size() - 2);
    EXPECT_GT(first, 0);
    EXPECT_LT(first, last / 10);
    // The toe region ends where the fibres are straight, at a strain of √(1 + 1.5²) − 1.
    for (std::size_t n = 0; n + 1 < curve.size(); ++n) {
        const double slope = results::slope_at(curve, n);
        EXPECT_GT(slope, 0.9 * first) << curve[n].strain;
        if (curve[n + 1].strain < 0.5) {
            EXPECT_LT(slope, last / 5) << curve[n].strain;
        }
        if (curve[n].strain > 1.1) {
            EXPECT_GT(slope, last / 2) << curve[n].strain;
        }
    }
}

TEST(LoadCurve, OfStraightFibresIsAlmostALine) {
    const auto curve = curve_of(0);
    EXPECT_NEAR(results::slope_at(curve, 0) / results::slope_at(curve, curve.size() - 2), 1, 0.1);
}

}  // namespace
}  // namespace pliant::test
