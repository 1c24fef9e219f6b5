// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Maxwell and Kelvin links [Choi2004, 2.2, Fig. 1] against closed forms.
// Covers: springs/state.cpp.

#include <pliant/models/springs.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "springs/random_networks.h"
#include "support/count_allocations.h"
#include "support/one_thread.h"

namespace pliant::test {
namespace {

/// A link along x from a fixed node to a node of small mass.
SpringNetwork one_link(double stiffness, double branch, double time, double mass, double damping) {
    SpringParts parts;
    parts.nodes = {{.rest = {0, 0, 0}, .fixed = true},
                   {.rest = {1, 0, 0}, .mass = mass, .damping = damping}};
    parts.links = {
        {.a = 0, .b = 1, .stiffness = stiffness, .branch_stiffness = branch, .branch_time = time}};
    return SpringNetwork::create(std::move(parts)).value();
}

SpringParts branched_lattice(Vec3i size) {
    auto parts = springs_of_lattice({.size = size, .node_damping = 1, .bulk = 0.3});
    for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0;
    for (std::size_t l = 0; l < parts->links.size(); ++l) {
        parts->links[l].branch_stiffness = l % 3 == 0 ? 0 : 0.5;
        parts->links[l].branch_time = 2 + double(l % 5);
    }
    return std::move(*parts);
}

TEST(Branches, TheForceOfAHeldLinkRelaxes) {
    // σ(t) = x (k + k' e^(−t/τ)) for Kelvin, with k = 0 for Maxwell.
    for (const double k : {10.0, 0.0}) {
        const double branch = 15, tau = 0.5, h = 5e-4, x = 0.1;
        auto tissue = SpringTissue::create(one_link(k, branch, tau, 1, 0),
                                           {.solver = SpringSolver::Explicit, .time_step = h});
        ASSERT_TRUE(tissue.ok()) << tissue.error().message;
        const std::array node{1};
        ASSERT_TRUE(tissue->hold(node).ok());
        ASSERT_TRUE(tissue->step(10, one_thread()).ok());
        ASSERT_TRUE(tissue->shift_held({x, 0, 0}).ok());
        for (int n = 0; n < 8; ++n) {
            const double expected = -x * (k + branch * std::exp(-n * 400 * h / tau));
            const auto reaction = tissue->reaction(node, ReactionLaw::Held);
            ASSERT_TRUE(reaction.ok());
            EXPECT_NEAR(reaction->force.x, expected, 0.002 * std::abs(expected)) << n;
            ASSERT_TRUE(tissue->step(400, one_thread()).ok());
        }
    }
}

/// A strain history: stretches that are added at measurements.
using Stretches = std::array<double, 8>;

// F(t) = Σ Δx_i G(t − t_i) with the kernel G(t) = k + k' e^(−t/τ) [Choi2004, Eq. 4].
TEST(Branches, AStretchInTwoStepsIsTheSumOfBothRelaxations) {
    const double k = 10, branch = 15, tau = 0.5, h = 5e-4;
    constexpr int kSteps = 200;
    const auto forces_of = [&](const Stretches& stretches) {
        auto tissue = SpringTissue::create(one_link(k, branch, tau, 1, 0),
                                           {.solver = SpringSolver::Explicit, .time_step = h})
                          .value();
        const std::array node{1};
        EXPECT_TRUE(tissue.hold(node).ok());
        EXPECT_TRUE(tissue.step(10, one_thread()).ok());
        Stretches forces{};
        for (std::size_t n = 0; n < forces.size(); ++n) {
            EXPECT_TRUE(tissue.shift_held({stretches[n], 0, 0}).ok());
            forces[n] = -tissue.reaction(node, ReactionLaw::Held)->force.x;
            EXPECT_TRUE(tissue.step(kSteps, one_thread()).ok());
        }
        return forces;
    };
    const Stretches first = forces_of({0.1}), second = forces_of({0, 0, 0, -0.04}),
                    both = forces_of({0.1, 0, 0, -0.04});
    for (std::size_t n = 0; n < both.size(); ++n) {
        EXPECT_NEAR(both[n], first[n] + second[n], 1e-9) << n;
        double expected = 0.1 * (k + branch * std::exp(-double(n) * kSteps * h / tau));
        if (n >= 3) expected -= 0.04 * (k + branch * std::exp(-double(n - 3) * kSteps * h / tau));
        EXPECT_NEAR(both[n], expected, 0.002 * first[0]) << n;
    }
    EXPECT_LT(both[7], 0.5 * both[0]);
}

// Small displacements of a network, with the inertia of its nodes.
TEST(Branches, ANetworkSuperposesSmallStretches) {
    constexpr double kStretch = 1e-4;
    const auto forces_of = [](const Stretches& stretches) {
        auto tissue =
            SpringTissue::create(SpringNetwork::create(branched_lattice({4, 4, 4})).value(), {})
                .value();
        std::vector<std::int32_t> top;
        for (std::int32_t n = 48; n < 64; ++n) top.push_back(n);
        EXPECT_TRUE(tissue.hold(top).ok());
        Stretches forces{};
        for (std::size_t n = 0; n < forces.size(); ++n) {
            EXPECT_TRUE(tissue.shift_held({0, 0, kStretch * stretches[n]}).ok());
            EXPECT_TRUE(tissue.step(10, one_thread()).ok());
            forces[n] = -tissue.reaction(top, ReactionLaw::Held)->force.z;
        }
        return forces;
    };
    const Stretches first = forces_of({1}), second = forces_of({0, 0, 0, 0.7}),
                    both = forces_of({1, 0, 0, 0.7});
    for (std::size_t n = 0; n < both.size(); ++n)
        EXPECT_NEAR(both[n], first[n] + second[n], 2e-3 * first[0]) << n;
    EXPECT_LT(first[7], 0.95 * first[0]);
    EXPECT_GT(second[7], 0.1 * first[0]);
}

TEST(Branches, AKelvinLinkCreepsFromItsFirstStretchToItsLast) {
    // x(t) = F/k (1 − k'/(k + k') e^(−t/τ_c)),  τ_c = τ (k + k')/k
    const double k = 10, branch = 10, tau = 0.5, h = 1e-4, force = 0.5;
    auto tissue = SpringTissue::create(one_link(k, branch, tau, 1e-6, 0.005),
                                       {.solver = SpringSolver::Explicit, .time_step = h});
    ASSERT_TRUE(tissue.ok()) << tissue.error().message;
    ASSERT_TRUE(tissue->load(std::array{1}, std::array{Vec3d{force, 0, 0}}).ok());
    for (int n = 1; n <= 8; ++n) {
        ASSERT_TRUE(tissue->step(2500, one_thread()).ok());
        const double t = 2500 * n * h;
        const double expected =
            force / k * (1 - branch / (k + branch) * std::exp(-t * k / (tau * (k + branch))));
        EXPECT_NEAR(tissue->displacement(1).x, expected, 0.002 * force / k) << n;
    }
}

TEST(Branches, AMaxwellLinkFlows) {
    // x(t) = F/k' (1 + t/τ)
    const double branch = 10, tau = 0.5, h = 1e-4, force = 0.5;
    auto tissue = SpringTissue::create(one_link(0, branch, tau, 1e-6, 0.002),
                                       {.solver = SpringSolver::Explicit, .time_step = h});
    ASSERT_TRUE(tissue.ok()) << tissue.error().message;
    ASSERT_TRUE(tissue->load(std::array{1}, std::array{Vec3d{force, 0, 0}}).ok());
    for (int n = 1; n <= 5; ++n) {
        ASSERT_TRUE(tissue->step(2500, one_thread()).ok());
        const double expected = force / branch * (1 + 2500 * n * h / tau);
        EXPECT_NEAR(tissue->displacement(1).x, expected, 0.002 * expected) << n;
    }
}

TEST(Branches, VectorsAndThreadsDontChangeABit) {
    const auto network = SpringNetwork::create(branched_lattice({24, 24, 12}));
    ASSERT_TRUE(network.ok());
    std::uint64_t expected = 0;
    for (const bool vectors : {true, false})
        for (const int threads : {1, 2, 4}) {
            const TaskArena arena(threads);
            auto tissue = SpringTissue::create(*network, {.depth = 11, .vectors = vectors});
            ASSERT_TRUE(tissue.ok());
            const std::int32_t node = 12 + 24 * (12 + 24 * 11);
            ASSERT_TRUE(tissue->load(std::array{node}, std::array{Vec3d{0.3, 0.2, -1}}).ok());
            ASSERT_TRUE(tissue->step(6, arena).ok());
            EXPECT_GT(norm(tissue->displacement(node)), 1e-3);
            if (expected == 0) expected = tissue->hash();
            EXPECT_EQ(tissue->hash(), expected) << vectors << ' ' << threads;
        }
}

TEST(Branches, TheirForcesOutliveAnotherContactAndAStepThatIsUndone) {
    auto tissue =
        SpringTissue::create(SpringNetwork::create(branched_lattice({6, 6, 6})).value(), {});
    ASSERT_TRUE(tissue.ok());
    const std::array held{3 + 6 * (3 + 6 * 5)};
    ASSERT_TRUE(tissue->hold(held).ok());
    ASSERT_TRUE(tissue->shift_held({0, 0, 0.4}).ok());
    ASSERT_TRUE(tissue->step(20, one_thread()).ok());
    const auto force = [&] { return tissue->reaction(held, ReactionLaw::Held)->force; };
    const Vec3d before = force();
    const double energy = tissue->elastic_energy();
    ASSERT_TRUE(tissue->load(std::array{1 + 6 * (1 + 6 * 4)}, std::array{Vec3d{0, 0, 0}}).ok());
    ASSERT_TRUE(tissue->step(0, one_thread()).ok());
    EXPECT_EQ(force(), before);
    EXPECT_EQ(tissue->elastic_energy(), energy);
    ASSERT_TRUE(tissue->load(std::array{1 + 6 * (1 + 6 * 4)}, std::array{Vec3d{0, 1e6, 0}}).ok());
    EXPECT_FALSE(tissue->step(1, one_thread()).ok());
    EXPECT_EQ(force(), before);
    tissue->reset();
    ASSERT_TRUE(tissue->step(0, one_thread()).ok());
    EXPECT_LT(norm(force()), 1e-12);
    EXPECT_LT(tissue->elastic_energy(), 1e-20);
}

TEST(Branches, AtAnEquilibriumTheyAreRelaxed) {
    auto parts = branched_lattice({5, 5, 5});
    auto plain = parts;
    for (SpringLink& link : plain.links) link.branch_stiffness = 0;
    const std::array node{2 + 5 * (2 + 5 * 4)};
    const std::array load{Vec3d{0.1, 0, -0.4}};
    std::array<Vec3d, 2> moved;
    for (int n = 0; n < 2; ++n) {
        auto tissue =
            SpringTissue::create(SpringNetwork::create(n ? plain : parts).value(), {.depth = 9});
        ASSERT_TRUE(tissue->load(node, load).ok());
        ASSERT_TRUE(tissue->find_equilibrium().ok());
        moved[std::size_t(n)] = tissue->displacement(node[0]);
        ASSERT_TRUE(tissue->step(50, one_thread()).ok());
        EXPECT_LT(norm(tissue->displacement(node[0]) - moved[std::size_t(n)]), 1e-7);
    }
    EXPECT_EQ(moved[0], moved[1]);
}

TEST(Branches, StepsUpToTheBoundAreStableAndLoseEnergy) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        SpringParts parts = random_parts(random, 60, seed % 2);
        for (SpringLink& link : parts.links) {
            link.rest_length = -1;
            link.branch_stiffness = random.ratio(0.1, 10);
            link.branch_time = random.ratio(0.01, 100);
        }
        const auto network = SpringNetwork::create(parts);
        const double longest = network->stable_time_step();
        auto tissue = SpringTissue::create(
            *network, {.solver = SpringSolver::Explicit, .time_step = longest});
        ASSERT_TRUE(tissue.ok());
        double start = 0;
        for (std::int32_t n = 0; n < network->node_count(); ++n) {
            if (network->nodes()[std::size_t(n)].fixed) continue;
            const Vec3d off = random.vector(1e-6);
            start = std::max(start, norm(off));
            ASSERT_TRUE(
                tissue->set_state(n, network->nodes()[std::size_t(n)].rest + off, {0, 0, 0}).ok());
        }
        ASSERT_TRUE(tissue->step(3000, one_thread()).ok());
        for (const Vec3d moved : tissue->displacements()) EXPECT_LT(norm(moved), 1e3 * start);
        EXPECT_FALSE(SpringTissue::create(*network, {.time_step = 1.001 * longest}).ok());
    }
    // The bound counts a branch in full: a chain with k + k' = 1 has that of k = 1.
    EXPECT_EQ(one_link(0.25, 0.75, 1e-3, 1, 0).stable_time_step(),
              one_link(1, 0, 0, 1, 0).stable_time_step());
}

TEST(Branches, NothingIsAllocatedInAStepAfterTheFirst) {
    auto tissue =
        SpringTissue::create(SpringNetwork::create(branched_lattice({8, 8, 8})).value(), {});
    ASSERT_TRUE(tissue->load(std::array{500}, std::array{Vec3d{0, 0, -0.1}}).ok());
    ASSERT_TRUE(tissue->step(2, one_thread()).ok());
    const std::int64_t before = allocation_count();
    ASSERT_TRUE(tissue->step(5, one_thread()).ok());
    EXPECT_EQ(allocation_count(), before);
}

TEST(Branches, WhatCantHaveThemIsNamed) {
    const auto error_of = [](SpringNetwork network, const SpringSettings& settings) {
        const auto tissue = SpringTissue::create(std::move(network), settings);
        return tissue.ok() ? std::string() : tissue.error().message;
    };
    const auto link = [] { return one_link(1, 1, 1, 1, 1); };
    EXPECT_EQ(error_of(link(), {}), "");
    EXPECT_EQ(error_of(link(), {.solver = SpringSolver::ImplicitEuler}),
              "solver: expected ForceTransmittal or Explicit for Maxwell branches");
    SpringParts parts{{{.rest = {0, 0, 0}}, {.rest = {1, 0, 0}}}, {{.a = 0, .b = 1}}, {}};
    parts.links[0].branch_stiffness = 1;
    EXPECT_EQ(SpringNetwork::create(parts).error().message,
              "network: link 0: expected a branch time above 0, found 0.000000");
    parts.links[0].branch_stiffness = -1;
    EXPECT_EQ(SpringNetwork::create(parts).error().message,
              "network: link 0: expected a branch stiffness of 0 or more, found -1.000000");
}

}  // namespace
}  // namespace pliant::test
