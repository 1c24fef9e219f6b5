// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The factored solver beside those of SpringTissue.

#include <gtest/gtest.h>
#include <pliant/research/springs.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "support/one_thread.h"
#include "support/random.h"

namespace pliant::test {
namespace {

constexpr std::int32_t kPressed = 2 + 5 * (2 + 5 * 3);
constexpr Vec3d kForce{0.5, 0, -2};

SpringNetwork pressed_block(double bulk = 0, double link_damping = 0) {
    auto parts = springs_of_lattice({.size = {5, 5, 4},
                                     .stiffness = {20, 20, 20},
                                     .link_damping = link_damping,
                                     .node_damping = 0.5,
                                     .bulk = bulk});
    for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0;
    return *SpringNetwork::create(std::move(*parts));
}

LocalGlobalSprings made(const SpringNetwork& network, double time_step, std::int32_t iterations) {
    auto springs = LocalGlobalSprings::create(network, time_step, iterations);
    EXPECT_TRUE(springs.ok());
    return std::move(springs).value();
}

std::vector<Vec3d> after(const SpringNetwork& network, double step, std::int32_t iterations,
                         double time) {
    LocalGlobalSprings springs = made(network, step, iterations);
    springs.load(kPressed, kForce);
    EXPECT_TRUE(springs.step(std::int32_t(std::lround(time / step))).ok());
    return springs.displacements();
}

SpringTissue pressed(const SpringNetwork& network, const SpringSettings& settings) {
    auto tissue = SpringTissue::create(network, settings);
    EXPECT_TRUE(tissue.ok());
    EXPECT_TRUE(tissue->load(std::array{kPressed}, std::array{kForce}).ok());
    return std::move(tissue).value();
}

double difference(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double largest = 0;
    for (std::size_t n = 0; n < a.size(); ++n) largest = std::max(largest, norm(a[n] - b[n]));
    return largest;
}

TEST(LocalGlobal, ErrorsHalveWithTheTimeStep) {
    const SpringNetwork network = pressed_block();
    SpringTissue exact = pressed(network, {.solver = SpringSolver::Explicit, .time_step = 1e-4});
    ASSERT_TRUE(exact.step(4000, one_thread()).ok());
    double last = 0;
    for (const double step : {8e-3, 4e-3, 2e-3}) {
        const double error = difference(exact.displacements(), after(network, step, 60, 0.4));
        EXPECT_LT(error, 0.1);
        if (last > 0) {
            EXPECT_GT(last / error, 1.7);
            EXPECT_LT(last / error, 2.3);
        }
        last = error;
    }
}

TEST(LocalGlobal, LongStepsEndInTheEquilibrium) {
    const SpringNetwork network = pressed_block();
    SpringTissue tissue = pressed(network, {});
    ASSERT_TRUE(tissue.find_equilibrium().ok());
    EXPECT_LT(difference(after(network, 5, 50, 1000), tissue.displacements()), 1e-6);
    EXPECT_GT(norm(tissue.displacement(kPressed)), 0.02);
}

TEST(LocalGlobal, HeldNodesArePutAndOthersFollow) {
    const SpringNetwork network = pressed_block();
    LocalGlobalSprings springs = made(network, 0.1, 20);
    const Vec3d rest = network.nodes()[std::size_t(kPressed)].rest;
    springs.hold(kPressed, rest + Vec3d{0, 0, -0.2});
    ASSERT_TRUE(springs.step(50).ok());
    EXPECT_NEAR(springs.displacements()[std::size_t(kPressed)].z, -0.2, 1e-14);
    EXPECT_LT(springs.displacements()[std::size_t(kPressed) + 1].z, -0.02);
    springs.release(kPressed);
    ASSERT_TRUE(springs.step(300).ok());
    for (const Vec3d moved : springs.displacements()) EXPECT_LT(norm(moved), 1e-3);
}

TEST(LocalGlobal, CutSpringsMoveAsANetworkWithoutTheLinks) {
    Random random(31);
    SpringNetwork network = pressed_block();
    std::vector<std::int32_t> cut;
    for (int n = 0; n < 40; ++n) cut.push_back(random.whole(0, int(network.links().size()) - 1));
    LocalGlobalSprings one = made(network, 0.02, 20);
    ASSERT_TRUE(one.step(1).ok());  // factored before the cut
    ASSERT_TRUE(one.cut_links(cut).ok());
    const std::vector<Vec3d> whole = after(network, 0.02, 20, 0.8);
    ASSERT_TRUE(network.cut_links(cut).ok());
    one.load(kPressed, kForce);
    ASSERT_TRUE(one.step(40).ok());
    EXPECT_LT(difference(one.displacements(), after(network, 0.02, 20, 0.8)), 1e-12);
    EXPECT_GT(difference(one.displacements(), whole), 1e-4);
}

TEST(LocalGlobal, WhatItCantDoIsRefused) {
    const auto says = [](const SpringNetwork& network, double step, std::int32_t iterations) {
        const auto springs = LocalGlobalSprings::create(network, step, iterations);
        return springs.ok() ? "" : springs.error().message;
    };
    EXPECT_EQ(says(pressed_block(), 0.1, 20), "");
    EXPECT_EQ(says(pressed_block(5), 0.1, 20), "network: expected one without volume energy");
    EXPECT_EQ(says(pressed_block(0, 1), 0.1, 20), "network: expected links without damping");
    EXPECT_NE(says(pressed_block(), 0, 20), "");
    EXPECT_NE(says(pressed_block(), 0.1, 0), "");
}

}  // namespace
}  // namespace pliant::test
