// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The three solvers beside each other.
// Covers: springs/sweep_*.cpp, springs/volume_*.cpp.

#include <pliant/models/springs.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "springs/random_networks.h"
#include "support/one_thread.h"

namespace pliant::test {
namespace {

SpringNetwork pressed_block(double bulk, double link_damping) {
    auto parts = springs_of_lattice({.size = {5, 5, 4},
                                     .stiffness = {20, 20, 20},
                                     .link_damping = link_damping,
                                     .node_damping = 0.5,
                                     .bulk = bulk});
    for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0;
    return *SpringNetwork::create(std::move(*parts));
}

constexpr std::int32_t kPressed = 2 + 5 * (2 + 5 * 3);

std::vector<Vec3d> after(const SpringNetwork& network, SpringSettings settings, double time) {
    auto tissue = SpringTissue::create(network, settings);
    EXPECT_TRUE(tissue.ok()) << tissue.error().message;
    EXPECT_TRUE(tissue->load(std::array{kPressed}, std::array{Vec3d{0.5, 0, -2}}).ok());
    const int steps = int(std::lround(time / tissue->time_step()));
    const auto report = tissue->step(steps, one_thread());
    EXPECT_TRUE(report.ok());
    EXPECT_EQ(report->steps, steps);
    return tissue->displacements();
}

double difference(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double largest = 0;
    for (std::size_t n = 0; n < a.size(); ++n) largest = std::max(largest, norm(a[n] - b[n]));
    return largest;
}

TEST(Implicit, ErrorsHalveWithTheTimeStep) {
    const SpringNetwork network = pressed_block(5, 0.3);
    const double time = 0.4;
    const std::vector<Vec3d> exact =
        after(network, {.solver = SpringSolver::Explicit, .time_step = 1e-4}, time);
    double last = 0;
    for (const double step : {8e-3, 4e-3, 2e-3}) {
        const double error = difference(
            exact,
            after(network, {.solver = SpringSolver::ImplicitEuler, .time_step = step}, time));
        EXPECT_LT(error, 0.1);
        if (last > 0) {
            EXPECT_GT(last / error, 1.7);
            EXPECT_LT(last / error, 2.3);
        }
        last = error;
    }
}

TEST(Implicit, LongStepsEndInTheEquilibrium) {
    const SpringNetwork network = pressed_block(5, 0);
    const SpringSettings settings{.solver = SpringSolver::ImplicitEuler, .time_step = 5};
    const std::vector<Vec3d> moved = after(network, settings, 1000);
    auto tissue = SpringTissue::create(network, {.solver = SpringSolver::ImplicitEuler});
    ASSERT_TRUE(tissue->load(std::array{kPressed}, std::array{Vec3d{0.5, 0, -2}}).ok());
    ASSERT_TRUE(tissue->find_equilibrium().ok());
    EXPECT_LT(difference(moved, tissue->displacements()), 1e-6);
    EXPECT_GT(norm(tissue->displacement(kPressed)), 0.02);
}

TEST(Implicit, HeldNodesArePutAndOthersFollow) {
    const SpringNetwork network = pressed_block(0, 0);
    auto tissue =
        SpringTissue::create(network, {.solver = SpringSolver::ImplicitEuler, .time_step = 0.1});
    ASSERT_TRUE(tissue->hold(std::array{kPressed}).ok());
    ASSERT_TRUE(tissue->shift_held({0, 0, -0.2}).ok());
    ASSERT_TRUE(tissue->step(50, one_thread()).ok());
    EXPECT_NEAR(tissue->displacement(kPressed).z, -0.2, 1e-14);
    EXPECT_LT(tissue->displacement(kPressed + 1).z, -0.02);
    ASSERT_TRUE(tissue->hold({}).ok());
    ASSERT_TRUE(tissue->step(300, one_thread()).ok());
    for (const Vec3d moved : tissue->displacements()) EXPECT_LT(norm(moved), 1e-3);
}

TEST(Solvers, ForceTransmittalOfAllLayersIsTheExplicitNetwork) {
    const SpringNetwork network = pressed_block(5, 0.3);
    const std::vector<Vec3d> all = after(network, {.solver = SpringSolver::Explicit}, 0.5);
    const std::vector<Vec3d> deep = after(network, {.depth = 50}, 0.5);
    EXPECT_LT(difference(all, deep), 1e-11);
    const std::vector<Vec3d> shallow = after(network, {.depth = 1}, 0.5);
    EXPECT_GT(difference(all, shallow), 1e-4);
}

TEST(Solvers, AShallowRegionIsStifferThanADeepOne) {
    const SpringNetwork network = pressed_block(0, 0);
    double last = 0;
    for (const int depth : {0, 1, 2}) {
        auto tissue = SpringTissue::create(network, {.depth = depth});
        ASSERT_TRUE(tissue->load(std::array{kPressed}, std::array{Vec3d{0, 0, -0.5}}).ok());
        ASSERT_TRUE(tissue->find_equilibrium().ok());
        const double sunk = -tissue->displacement(kPressed).z;
        EXPECT_GT(sunk, last);
        last = sunk;
    }
}

TEST(Solvers, CutTissueMovesAsANetworkWithoutTheLinks) {
    const std::uint64_t seed = 31;
    SCOPED_TRACE(seed);
    for (const SpringSolver solver :
         {SpringSolver::ForceTransmittal, SpringSolver::Explicit, SpringSolver::ImplicitEuler}) {
        Random random(seed);
        SpringNetwork network = pressed_block(0, 0);
        std::vector<std::int32_t> cut;
        for (int n = 0; n < 40; ++n)
            cut.push_back(random.whole(0, int(network.links().size()) - 1));
        const SpringSettings settings{.solver = solver, .depth = 4, .time_step = 0.02};
        const std::array<Vec3d, 1> force{{{0.5, 0, -2}}};
        auto one = SpringTissue::create(network, settings);
        ASSERT_TRUE(one->load(std::array{kPressed}, force).ok());
        ASSERT_TRUE(one->step(1, one_thread()).ok());
        one->reset();
        const auto report = one->cut_links(cut);
        ASSERT_TRUE(report.ok());
        EXPECT_GT(report->cut_links, 30);
        ASSERT_TRUE(network.cut_links(cut).ok());
        auto other = SpringTissue::create(network, settings);
        ASSERT_TRUE(other->load(std::array{kPressed}, force).ok());
        ASSERT_TRUE(one->step(40, one_thread()).ok());
        ASSERT_TRUE(other->step(40, one_thread()).ok());
        EXPECT_EQ(one->hash(), other->hash());
        auto whole = SpringTissue::create(pressed_block(0, 0), settings);
        ASSERT_TRUE(whole->load(std::array{kPressed}, force).ok());
        ASSERT_TRUE(whole->step(40, one_thread()).ok());
        EXPECT_NE(one->hash(), whole->hash());
    }
}

TEST(Solvers, ATolerance0IsRefused) {
    EXPECT_FALSE(SpringTissue::create(pressed_block(0, 0), {.solve_tolerance = 0}).ok());
}

}  // namespace
}  // namespace pliant::test
