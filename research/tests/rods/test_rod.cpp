// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The rod: its solver against elimination, and its interface. Closed forms and published shapes are
// in test_published.cpp.
// Covers: pbd/rotations.cpp.

#include <pliant/research/rod.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "pbd/rotations.h"
#include "rods/block_chain.h"
#include "support/count_allocations.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using std::numbers::pi;

Rod made(const RodSettings& settings) {
    auto rod = Rod::create(settings);
    EXPECT_TRUE(rod.ok());
    return std::move(rod).value();
}

TEST(Rod, AChainOfBlocksIsSolvedAsByElimination) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const int blocks = random.whole(1, 7), size = 6 * blocks;
        // MᵀM of a matrix that couples neighbours only.
        std::vector<double> a(std::size_t(size * size), 0), m = a;
        const auto at = [&](std::vector<double>& of, int r, int c) -> double& {
            return of[std::size_t(r * size + c)];
        };
        for (int r = 0; r < size; ++r)
            for (int c = 0; c < size; ++c)
                if (r / 6 == c / 6 || r / 6 == c / 6 + 1) at(m, r, c) = random.real(-1, 1);
        for (int r = 0; r < size; ++r)
            for (int c = 0; c < size; ++c) {
                for (int k = 0; k < size; ++k) at(a, r, c) += at(m, k, r) * at(m, k, c);
                if (r == c) at(a, r, c) += 0.5;
            }
        pbd::BlockChain chain{std::size_t(blocks)};
        std::vector<pbd::BlockVector> x(std::size_t(blocks), pbd::BlockVector{}), b;
        for (auto& block : x)
            for (double& value : block) value = random.real(-1, 1);
        b = x;
        for (int i = 0; i < blocks; ++i)
            for (int r = 0; r < 6; ++r) {
                double sum = 0;
                for (int c = 0; c < size; ++c)
                    sum += at(a, 6 * i + r, c) * x[std::size_t(c / 6)][std::size_t(c % 6)];
                b[std::size_t(i)][std::size_t(r)] = sum;
                for (int c = 0; c < 6; ++c) {
                    const auto to = std::size_t(6 * r + c);
                    chain.diagonal[std::size_t(i)][to] = at(a, 6 * i + r, 6 * i + c);
                    if (i + 1 < blocks)
                        chain.upper[std::size_t(i)][to] = at(a, 6 * i + r, 6 * (i + 1) + c);
                }
            }
        chain.solve(b);
        for (std::size_t i = 0; i < x.size(); ++i)
            for (std::size_t r = 0; r < 6; ++r) EXPECT_NEAR(b[i][r], x[i][r], 1e-10);
    }
}

TEST(Rod, WhatTurnsAtTheBaseTurnsAtTheTip) {
    Rod rod = made({.segments = 30, .damping = 5});
    for (int n = 1; n <= 100; ++n) {
        ASSERT_TRUE(rod.set_base({0, 0, 0.001 * n}, rotation_by({0, 0, 0.02 * n})).ok());
        ASSERT_TRUE(rod.step(1).ok());
    }
    ASSERT_TRUE(rod.step(600).ok());
    EXPECT_LT(norm(rod.position(30) - Vec3d{0, 0, 1.1}), 1e-6);
    EXPECT_LT(norm(rotation_vector(rod.orientation(29)) - Vec3d{0, 0, 2}), 1e-6);
    // Held at its tip by a moment instead, it is twisted by M L / GJ but for half a segment.
    ASSERT_TRUE(rod.load_moment(29, {0, 0, 0.5}).ok());
    ASSERT_TRUE(rod.step(600).ok());
    EXPECT_NEAR(rotation_vector(rod.orientation(29)).z, 2 + 0.5 * (1 - 0.5 / 30), 1e-6);
    EXPECT_NEAR(rod.base_moment().z, 0.5, 1e-6);
}

TEST(Rod, ASteeredTipBendsWhereItIsToldAndTurnsWithTheBase) {
    for (const double direction : {0.0, 1.0, -2.0}) {
        Rod rod = made({.segments = 40, .tip_segments = 10, .damping = 5});
        ASSERT_TRUE(rod.steer(0.8, direction).ok());
        ASSERT_TRUE(rod.step(800).ok());
        for (int i = 0; i < 30; ++i) EXPECT_LT(norm(rod.turn(i)), 1e-6);
        const Vec3d tip = rod.position(40);
        EXPECT_NEAR(std::atan2(tip.y, tip.x), direction, 1e-6);
        const Vec3d ahead = rotated(rod.orientation(39), {0, 0, 1});
        EXPECT_NEAR(std::acos(ahead.z), 0.8, 1e-6);
        EXPECT_LT(rod.elastic_energy(), 1e-12);
        ASSERT_TRUE(rod.set_base({0, 0, 0}, rotation_by({0, 0, 0.5})).ok());
        ASSERT_TRUE(rod.step(800).ok());
        EXPECT_LT(norm(rod.position(40) - rotated(rotation_by({0, 0, 0.5}), tip)), 1e-5);
    }
}

TEST(Rod, ARodThatSwingsLosesEnergyAndNothingIsAllocated) {
    Rod rod = made({.segments = 60, .time_step = 0.005, .iterations = 3, .gravity = {0, -9.81, 0}});
    const auto energy = [&] {
        double e = rod.elastic_energy();
        for (int n = 1; n <= 60; ++n)
            e += (n == 60 ? 0.5 : 1.0) / 60 *
                 (0.5 * dot(rod.velocity(n), rod.velocity(n)) + 9.81 * rod.position(n).y);
        return e;
    };
    ASSERT_TRUE(rod.step(1).ok());
    const std::int64_t before = allocation_count();
    double last = energy(), lowest = 0;
    for (int n = 0; n < 400; ++n) {
        ASSERT_TRUE(rod.step(1).ok());
        const double now = energy();
        EXPECT_LT(now, last + 2e-3);  // the turning's energy isn't counted
        last = now;
        lowest = std::min(lowest, rod.position(60).y);
    }
    EXPECT_EQ(allocation_count(), before);
    EXPECT_LT(lowest, -0.7);
}

TEST(Rod, AReleasedTipIsFreeAgain) {
    auto rod = Rod::create({.segments = 20, .damping = 5});
    auto never_held = Rod::create({.segments = 20, .damping = 5});
    ASSERT_TRUE(rod->hold_tip({0.1, 0, 0.9}, rotation_by({0, 0.3, 1})).ok());
    ASSERT_TRUE(rod->step(200).ok());
    EXPECT_LT(norm(rod->position(20) - Vec3d{0.1, 0, 0.9}), 1e-12);
    EXPECT_GT(rod->elastic_energy(), 0.1);
    EXPECT_EQ(rod->inverse_mass(20), 0);
    rod->release_tip();
    rod->release_tip();
    EXPECT_EQ(rod->inverse_mass(20), never_held->inverse_mass(20));
    ASSERT_TRUE(rod->step(1000).ok());
    EXPECT_LT(norm(rod->position(20) - Vec3d{0, 0, 1}), 1e-6);
    EXPECT_LT(rod->elastic_energy(), 1e-10);
    EXPECT_EQ(rod->hold_tip({0, 0, 0}, {2, 0, 0, 0}).error().message,
              "hold_tip: expected a rotation of length 1, found 2");
    EXPECT_FALSE(rod->hold_tip({std::nan(""), 0, 0}, {}).ok());
}

TEST(Rod, BadInputIsRefusedWithOneLineThatNamesIt) {
    const struct {
        const char* says;
        std::function<void(RodSettings&)> spoil;
    } cases[] = {
        {"segments: expected 1 to 1000000, found 0", [](RodSettings& s) { s.segments = 0; }},
        {"mass: expected above 0, found 0", [](RodSettings& s) { s.mass = 0; }},
        {"bend_stiffness: expected above 0, found nan",
         [](RodSettings& s) { s.bend_stiffness = std::nan(""); }},
        {"tip_segments: expected 0 to 50, found 51", [](RodSettings& s) { s.tip_segments = 51; }},
        {"frame: expected a rotation of length 1, found 2",
         [](RodSettings& s) {
             s.frame = {2, 0, 0, 0};
         }},
        {"damping: expected 0 to 100, one over the sub-step, found 101",
         [](RodSettings& s) { s.damping = 101; }},
    };
    for (const auto& c : cases) {
        RodSettings settings;
        c.spoil(settings);
        const auto rod = Rod::create(settings);
        ASSERT_FALSE(rod.ok()) << c.says;
        EXPECT_EQ(rod.error().message, c.says);
    }
    Rod rod = made({});
    EXPECT_EQ(rod.load(51, {0, 0, 0}).error().message, "load: expected a node up to 50, found 51");
    EXPECT_FALSE(rod.load_moment(50, {0, 0, 0}).ok());
    EXPECT_FALSE(rod.steer(1, 0).ok());
    EXPECT_FALSE(rod.set_base({0, 0, 0}, {0, 0, 0, 0}).ok());
    ASSERT_TRUE(rod.load(50, {1e308, 1e308, 0}).ok());
    const auto status = rod.step(50);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().code, ErrorCode::LimitExceeded);
    EXPECT_TRUE(is_finite(rod.position(50)));
}

}  // namespace
}  // namespace pliant::test
