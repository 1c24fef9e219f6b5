// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <random>

#include "render/cubic.h"

namespace pliant::render {
namespace {

Cubic with_roots(double scale, double a, double b, double c) {
    return {-scale * a * b * c, scale * (a * b + b * c + c * a), -scale * (a + b + c), scale};
}

TEST(Cubic, FindsTheFirstOfThreeRootsWithTheWantedSign) {
    const Cubic f = with_roots(1, 0.2, 0.5, 0.8);  // − + − +
    bool above = false;
    EXPECT_NEAR(first_turn(f, true, above).value_or(-1), 0.2, 1e-13);
    EXPECT_TRUE(above);
    above = false;
    EXPECT_NEAR(first_turn(f, false, above).value_or(-1), 0.5, 1e-13);
    EXPECT_FALSE(above);
}

TEST(Cubic, ReportsTheSideAtTheEndWhereNothingTurns) {
    bool above = false;
    EXPECT_FALSE(first_turn({-1, 0.5, 0, 0}, true, above));
    EXPECT_FALSE(above);
    EXPECT_FALSE(first_turn({-1, 3, 0, 0}, false, above));
    EXPECT_TRUE(above);
}

TEST(Cubic, TurnsOnTheFaceWhereTheSideBeforeDiffers) {
    bool above = false;
    EXPECT_EQ(first_turn({1e-12, 1, 0, 0}, true, above).value_or(-1), 0.0);
    above = true;
    EXPECT_EQ(first_turn({-1e-12, -1, 0, 0}, false, above).value_or(-1), 0.0);
}

TEST(Cubic, EqualsADenseScanOnRandomRoots) {
    const unsigned seed = 20260101;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-0.6, 1.6);
    int hits = 0;
    for (int trial = 0; trial < 20000; ++trial) {
        double r[3] = {place(random), place(random), place(random)};
        std::sort(r, r + 3);
        const bool positive = random() % 2 == 0, to_above = random() % 2 == 0;
        const Cubic f = with_roots(positive ? 2.5 : -2.5, r[0], r[1], r[2]);
        if (std::min(r[1] - r[0], r[2] - r[1]) < 1e-4) continue;
        double expected = 2;  // the root's turn alternates: the last one turns to the scale's sign
        for (int i = 2; i >= 0; --i) {
            const bool turns_above = positive == (i != 1);
            if (turns_above == to_above && r[i] > 0 && r[i] < 1) expected = r[i];
        }
        bool above = f.c0 >= 0;
        const auto s = first_turn(f, to_above, above);
        ASSERT_EQ(s.has_value(), expected < 2) << "seed " << seed << " trial " << trial;
        if (!s) continue;
        ++hits;
        ASSERT_NEAR(*s, expected, 1e-9) << "seed " << seed << " trial " << trial;
    }
    EXPECT_GT(hits, 5000);
}

}  // namespace
}  // namespace pliant::render
