// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Force transmittal and the explicit network against a plain implementation of the paper's
// formulas, and against closed forms.
// Covers: springs/tissue*.cpp, springs/transmittal*.cpp.

#include <pliant/models/springs.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "springs/random_networks.h"
#include "support/count_allocations.h"
#include "support/one_thread.h"

namespace pliant::test {
namespace {

std::vector<std::int32_t> movable_nodes(const SpringNetwork& network, Random& random, int count) {
    std::vector<std::int32_t> nodes;
    while (int(nodes.size()) < count) {
        const int node = random.whole(0, network.node_count() - 1);
        if (!network.nodes()[std::size_t(node)].fixed &&
            std::find(nodes.begin(), nodes.end(), node) == nodes.end())
            nodes.push_back(node);
    }
    return nodes;
}

TEST(Motion, StepsAreTheFormulasOfThePaperWrittenOut) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        SpringParts parts = seed % 3 ? random_parts(random, random.whole(2, 120), seed % 2)
                                     : random_block(random, {9, 5, 4}, 0.4, seed % 2);
        for (SpringNode& node : parts.nodes) node.damping += 0.5;
        const auto network = SpringNetwork::create(parts);
        ASSERT_TRUE(network.ok());
        const int depth = random.whole(0, 6);
        const double step = 0.5 * network->stable_time_step();
        auto tissue = SpringTissue::create(
            *network, {.depth = depth, .time_step = step, .vectors = seed % 4 > 1});
        ASSERT_TRUE(tissue.ok()) << tissue.error().message;
        const auto sources = movable_nodes(*network, random, 1 + int(seed % 2));
        std::vector<Vec3d> forces;
        PlainStepper plain(*network, step);
        for (const std::int32_t s : sources)
            plain.load[std::size_t(s)] = forces.emplace_back(random.vector(0.5));
        ASSERT_TRUE(tissue->load(sources, forces).ok());
        const auto order = transmittal_order(*network, sources, depth);
        for (int n = 0; n < 30; ++n) {
            ASSERT_TRUE(tissue->step(1, one_thread()).ok());
            plain.step(*order);
        }
        for (std::int32_t n = 0; n < network->node_count(); ++n)
            EXPECT_LT(norm(tissue->position(n) - plain.x[std::size_t(n)]), 1e-11) << n;
    }
}

TEST(Motion, VectorsAndThreadsDontChangeABit) {
    auto parts = springs_of_lattice({.size = {24, 24, 12}, .node_damping = 1, .bulk = 0.3});
    for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0;
    const auto network = SpringNetwork::create(*parts);
    std::uint64_t expected = 0;
    for (const bool vectors : {true, false})
        for (const int threads : {1, 2, 4}) {
            const TaskArena arena(threads);
            auto tissue = SpringTissue::create(*network, {.depth = 11, .vectors = vectors});
            ASSERT_TRUE(tissue.ok());
            const std::int32_t node = 12 + 24 * (12 + 24 * 11);
            ASSERT_TRUE(tissue->load(std::array{node}, std::array{Vec3d{0.3, 0.2, -1}}).ok());
            const auto report = tissue->step(6, arena);
            ASSERT_TRUE(report.ok());
            EXPECT_GT(report->active_nodes, 2000);
            EXPECT_GT(norm(tissue->displacement(node)), 1e-3);
            if (expected == 0) expected = tissue->hash();
            EXPECT_EQ(tissue->hash(), expected) << vectors << ' ' << threads;
        }
}

TEST(Motion, HexahedraAndTetrahedraHaveTheirVolumeForces) {
    Random random(5);
    SpringParts parts = random_block(random, {7, 5, 4}, 0.4, true);
    // A corner of each third hexahedron: packs of tetrahedra that aren't full.
    for (std::size_t c = 0, count = parts.cells.size(); c < count; c += 3) {
        const auto& n = parts.cells[c].nodes;
        parts.cells.push_back({.nodes = {n[0], n[1], n[3], n[4]}, .node_count = 4, .bulk = 0.7});
    }
    const auto network = SpringNetwork::create(parts);
    ASSERT_TRUE(network.ok());
    const double step = 0.5 * network->stable_time_step();
    const auto sources = movable_nodes(*network, random, 2);
    const std::array forces{random.vector(0.5), random.vector(0.5)};
    PlainStepper plain(*network, step);
    for (std::size_t n = 0; n < 2; ++n) plain.load[std::size_t(sources[n])] = forces[n];
    const auto order = transmittal_order(*network, sources, 4);
    for (int n = 0; n < 30; ++n) plain.step(*order);
    std::array<std::uint64_t, 2> hashes{};
    for (const bool vectors : {false, true}) {
        auto tissue =
            SpringTissue::create(*network, {.depth = 4, .time_step = step, .vectors = vectors});
        ASSERT_TRUE(tissue.ok());
        ASSERT_TRUE(tissue->load(sources, forces).ok());
        ASSERT_TRUE(tissue->step(30, one_thread()).ok());
        for (std::int32_t n = 0; n < network->node_count(); ++n)
            EXPECT_LT(norm(tissue->position(n) - plain.x[std::size_t(n)]), 1e-11) << n;
        hashes[vectors] = tissue->hash();
    }
    EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Motion, NothingIsAllocatedInAStepAfterTheFirst) {
    auto parts = springs_of_lattice({.size = {20, 20, 10}, .node_damping = 1, .bulk = 0.3});
    const auto network = SpringNetwork::create(*parts);
    for (const int threads : {1, 2}) {
        const TaskArena arena(threads);
        auto tissue = SpringTissue::create(*network, {.depth = 14});
        const std::array nodes{10 + 20 * 10, 11 + 20 * 10};
        std::int64_t before = 0;
        for (int turn = 0; turn < 4; ++turn) {
            before = allocation_count();
            ASSERT_TRUE(tissue->step(2, arena).ok());
            if (turn == 0) {
                ASSERT_TRUE(tissue->hold(nodes).ok());
            }
            ASSERT_TRUE(tissue->shift_held({0, 0, -0.01}).ok());
        }
        EXPECT_EQ(allocation_count() - before, 0);
    }
}

// Test case 18 of the references.
TEST(Motion, EndsInTheEquilibrium) {
    auto parts = springs_of_lattice({.size = {7, 7, 4}, .node_damping = 3});
    for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0;
    const auto network = SpringNetwork::create(*parts);
    auto tissue = SpringTissue::create(*network, {.depth = 20});
    ASSERT_TRUE(tissue.ok()) << tissue.error().message;
    const std::array node{3 + 7 * (3 + 7 * 3)};
    ASSERT_TRUE(tissue->load(node, std::array{Vec3d{0.01, 0, -0.02}}).ok());
    ASSERT_TRUE(tissue->step(6000, one_thread()).ok());
    const std::vector<Vec3d> moved = tissue->displacements();
    ASSERT_TRUE(tissue->find_equilibrium().ok());
    for (std::size_t n = 0; n < moved.size(); ++n)
        EXPECT_LT(norm(moved[n] - tissue->displacement(std::int32_t(n))), 1e-8) << n;
    EXPECT_GT(norm(moved[std::size_t(node[0])]), 1e-3);
}

SpringNetwork oscillator(double mass, double stiffness, double damping, double link_damping) {
    return *SpringNetwork::create(
        {{{.rest = {0, 0, 0}, .fixed = true},
          {.rest = {1, 0, 0}, .mass = mass, .damping = damping}},
         {{.a = 0, .b = 1, .stiffness = stiffness, .damping = link_damping}},
         {}});
}

TEST(Motion, AnOscillatorHasItsPeriodAndItsDecay) {
    for (const double link : {0.0, 1.0}) {  // damping of the node, or of the link
        const double m = 2, k = 50, d = 0.7, h = 1e-4;
        auto tissue = SpringTissue::create(oscillator(m, k, d * (1 - link), d * link),
                                           {.solver = SpringSolver::Explicit, .time_step = h});
        ASSERT_TRUE(tissue->set_state(1, {1.25, 0, 0}, {0, 0, 0}).ok());
        const double decay = d / (2 * m), omega = std::sqrt(k / m - decay * decay);
        for (int n = 0; n < 4; ++n) {
            ASSERT_TRUE(tissue->step(5000, one_thread()).ok());
            const double t = 5000 * h * (n + 1);
            const double expected = 0.25 * std::exp(-decay * t) *
                                    (std::cos(omega * t) + decay / omega * std::sin(omega * t));
            EXPECT_NEAR(tissue->displacement(1).x, expected, 5e-4);
        }
    }
}

// Test case 24 of the references: ε(t) = F/k (1 − e^(−kt/d)) where the mass is negligible.
TEST(Motion, AVoigtLinkCreeps) {
    const double k = 10, d = 5, h = 1e-4;
    auto tissue = SpringTissue::create(oscillator(1e-5, k, d, 0),
                                       {.solver = SpringSolver::Explicit, .time_step = h});
    ASSERT_TRUE(tissue.ok());
    ASSERT_TRUE(tissue->load(std::array{1}, std::array{Vec3d{0.5, 0, 0}}).ok());
    for (int n = 1; n <= 5; ++n) {
        ASSERT_TRUE(tissue->step(2500, one_thread()).ok());
        const double expected = 0.5 / k * (1 - std::exp(-k * 2500 * n * h / d));
        EXPECT_NEAR(tissue->displacement(1).x, expected, 0.002 * 0.5 / k);
    }
}

// Test case 25 of the references: π d ω a² a cycle for a driven Voigt link.
TEST(Motion, AVoigtLinkHasAHysteresisLoopThatGrowsWithItsDamping) {
    for (const double d : {0.5, 1.0, 2.0}) {
        const double k = 10, h = 1e-4, a = 0.05, omega = 2 * std::numbers::pi;
        auto tissue = SpringTissue::create(oscillator(1e-5, k, d, 0),
                                           {.solver = SpringSolver::Explicit, .time_step = h});
        double energy = 0, last = 0;
        for (int n = 0; n < 20000; ++n) {
            const double t = n * h;  // the force that keeps x = a sin ωt where there is no mass
            const double force = k * a * std::sin(omega * t) + d * a * omega * std::cos(omega * t);
            ASSERT_TRUE(tissue->load(std::array{1}, std::array{Vec3d{force, 0, 0}}).ok());
            ASSERT_TRUE(tissue->step(1, one_thread()).ok());
            const double x = tissue->displacement(1).x;
            if (n >= 10000) energy += force * (x - last);
            last = x;
        }
        const double expected = std::numbers::pi * d * omega * a * a;
        EXPECT_NEAR(energy, expected, 0.02 * expected);
    }
}

TEST(Motion, AChainHasTheFrequencyOfItsFirstMode) {
    constexpr int kNodes = 21;
    SpringParts parts;
    for (int n = 0; n < kNodes; ++n)
        parts.nodes.push_back({.rest = {double(n), 0, 0}, .fixed = n == 0 || n == kNodes - 1});
    for (int n = 0; n + 1 < kNodes; ++n)
        parts.links.push_back({.a = n, .b = n + 1, .stiffness = 4});
    const auto network = SpringNetwork::create(parts);
    // Exact for a chain: h = 2/ω with ω = 2√(k/m).
    EXPECT_NEAR(network->stable_time_step(), 0.5, 1e-12);
    const double omega = 2 * std::sqrt(4.0) * std::sin(std::numbers::pi / (2 * (kNodes - 1)));
    auto tissue =
        SpringTissue::create(*network, {.solver = SpringSolver::Explicit, .time_step = 1e-3});
    for (int n = 1; n + 1 < kNodes; ++n)
        ASSERT_TRUE(tissue
                        ->set_state(n,
                                    {n + 0.1 * std::sin(std::numbers::pi * n / (kNodes - 1)), 0, 0},
                                    {0, 0, 0})
                        .ok());
    const int half = int(std::lround(std::numbers::pi / omega / 1e-3));
    ASSERT_TRUE(tissue->step(half, one_thread()).ok());
    EXPECT_NEAR(tissue->displacement(10).x, -0.1, 2e-4);
}

TEST(Motion, EnergyAndMomentumOfAFreeUndampedNetworkAreKept) {
    const std::uint64_t seed = 5;
    SCOPED_TRACE(seed);
    Random random(seed);
    SpringParts parts = random_block(random, {5, 4, 4}, 2, false);
    for (SpringNode& node : parts.nodes) node.fixed = false;
    const auto network = SpringNetwork::create(parts);
    auto tissue = SpringTissue::create(*network, {.solver = SpringSolver::Explicit,
                                                  .time_step = 0.05 * network->stable_time_step()});
    for (std::int32_t n = 0; n < network->node_count(); ++n)
        ASSERT_TRUE(tissue
                        ->set_state(n, network->nodes()[std::size_t(n)].rest + random.vector(0.03),
                                    random.vector(0.1))
                        .ok());
    const Vec3d momentum = tissue->momentum();
    const double energy = tissue->elastic_energy() + tissue->kinetic_energy();
    for (int n = 0; n < 20; ++n) {
        ASSERT_TRUE(tissue->step(100, one_thread()).ok());
        EXPECT_LT(norm(tissue->momentum() - momentum), 1e-10);
        EXPECT_NEAR(tissue->elastic_energy() + tissue->kinetic_energy(), energy, 0.06 * energy);
    }
}

TEST(Motion, StepsUpToTheBoundAreStableAndLongerOnesAreRefused) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        SpringParts parts = seed % 2 ? random_parts(random, 60, seed % 4 == 1)
                                     : random_block(random, {6, 5, 4}, 3, seed % 4 == 2);
        for (SpringLink& link : parts.links) link.rest_length = -1;
        for (SpringNode& node : parts.nodes) node.damping += 0.2;
        const auto network = SpringNetwork::create(parts);
        const double longest = network->stable_time_step();
        ASSERT_GT(longest, 0);
        auto tissue = SpringTissue::create(*network, {.depth = 100, .time_step = longest});
        ASSERT_TRUE(tissue.ok());
        ASSERT_TRUE(
            tissue->load(movable_nodes(*network, random, 1), std::array{Vec3d{0, 0, 0}}).ok());
        double start = 0;
        for (std::int32_t n = 0; n < network->node_count(); ++n) {
            const SpringNode& node = network->nodes()[std::size_t(n)];
            if (node.fixed) continue;
            const Vec3d off = random.vector(1e-6);
            start = std::max(start, norm(off));
            ASSERT_TRUE(tissue->set_state(n, node.rest + off, {0, 0, 0}).ok());
        }
        ASSERT_TRUE(tissue->step(3000, one_thread()).ok());
        for (const Vec3d moved : tissue->displacements()) EXPECT_LT(norm(moved), 1e3 * start);
        const auto refused = SpringTissue::create(*network, {.time_step = 1.001 * longest});
        ASSERT_FALSE(refused.ok());
        EXPECT_EQ(refused.error().message.rfind("time_step: expected at most ", 0), 0u);
    }
}

TEST(Motion, TheBoundOfALatticeIsNearTheFirstUnstableStep) {
    const auto network = SpringNetwork::create(*springs_of_lattice({.size = {8, 8, 8}}));
    PlainStepper plain(*network, 1.05 * network->stable_time_step());
    Random random(3);
    for (Vec3d& x : plain.x) x = x + random.vector(1e-9);
    plain.before = plain.x;
    const auto order = transmittal_order(*network, std::array{0}, 100);
    for (int n = 0; n < 200; ++n) plain.step(*order);
    double largest = 0;
    for (std::size_t n = 0; n < plain.x.size(); ++n)
        largest = std::max(largest, norm(plain.x[n] - network->nodes()[n].rest));
    EXPECT_GT(largest, 1e-5);
}

TEST(Motion, AStepThatTearsTheShapeApartIsTakenBackAndNamed) {
    auto tissue = SpringTissue::create(oscillator(1, 1, 0, 0), {.time_step = 1.4});
    ASSERT_TRUE(tissue.ok());
    ASSERT_TRUE(tissue->load(std::array{1}, std::array{Vec3d{0, 1e6, 0}}).ok());
    const auto report = tissue->step(10, one_thread());
    ASSERT_FALSE(report.ok());
    EXPECT_NE(report.error().message.find("a node moved by more than the longest link"),
              std::string::npos)
        << report.error().message;
    EXPECT_EQ(tissue->displacement(1), (Vec3d{0, 0, 0}));
}

TEST(Motion, OnlyNodesWithinTheDepthMove) {
    const auto network = SpringNetwork::create(*springs_of_sheet({.columns = 30, .rows = 30}));
    auto tissue = SpringTissue::create(*network, {.depth = 4});
    const std::array node{15 + 30 * 15};
    ASSERT_TRUE(tissue->load(node, std::array{Vec3d{0.1, 0.2, 0}}).ok());
    const auto report = tissue->step(100, one_thread());
    EXPECT_EQ(report->active_nodes, 61);
    const auto order = transmittal_order(*network, node, 4);
    std::vector<std::uint8_t> reached(std::size_t(network->node_count()), 0);
    for (const std::int32_t n : order->nodes) reached[std::size_t(n)] = 1;
    for (std::int32_t n = 0; n < network->node_count(); ++n)
        EXPECT_EQ(norm(tissue->displacement(n)) > 0, reached[std::size_t(n)] == 1) << n;
}

TEST(Motion, AContactThatComesBackFindsWhatIsLeftOfTheOther) {
    const auto network = SpringNetwork::create(*springs_of_sheet({.columns = 30, .rows = 5}));
    auto tissue = SpringTissue::create(*network, {.depth = 3});
    const auto press = [&](std::int32_t node, double force) {
        ASSERT_TRUE(tissue->load(std::array{node}, std::array{Vec3d{0, 0, force}}).ok());
        ASSERT_TRUE(tissue->step(20, one_thread()).ok());
    };
    press(62, 0.1);
    const Vec3d left = tissue->displacement(62);
    EXPECT_GT(norm(left), 0);
    for (int far = 70; far < 88; ++far) press(far, 0.1);
    EXPECT_EQ(tissue->displacement(62), left);
    EXPECT_EQ(tissue->velocity(62), (Vec3d{0, 0, 0}));
    press(62, 0);
    EXPECT_FALSE(tissue->displacement(62) == left);
    tissue->reset();
    for (const Vec3d moved : tissue->displacements()) EXPECT_EQ(moved, (Vec3d{0, 0, 0}));
}

TEST(Motion, WhatCantBeLoadedOrHeldIsNamed) {
    auto parts = springs_of_sheet({.columns = 3, .rows = 3});
    parts->nodes[4].fixed = true;
    auto tissue = SpringTissue::create(*SpringNetwork::create(*parts), {});
    const std::array<Vec3d, 1> force{{{1, 0, 0}}};
    EXPECT_EQ(tissue->load(std::array{4}, force).error().message,
              "load: expected nodes that can move, found node 4, which is fixed");
    EXPECT_EQ(tissue->load(std::array{-1}, force).error().message,
              "load: expected nodes below 9, found -1");
    EXPECT_EQ(tissue->hold(std::array{0, 0}).error().message,
              "hold: expected each node once, found node 0 again");
    EXPECT_EQ(tissue->load(std::array{0}, std::array{Vec3d{NAN, 0, 0}}).error().message,
              "load: expected three numbers as the force on node 0");
    EXPECT_FALSE(tissue->move_held(force).ok());
    EXPECT_FALSE(tissue->step(-1, one_thread()).ok());
    EXPECT_FALSE(tissue->set_depth(-1).ok());
    EXPECT_FALSE(SpringTissue::create(*SpringNetwork::create(*parts), {.time_step = -1}).ok());
}

TEST(Motion, AHeldNodeGoesWhereItIsPut) {
    const auto network = SpringNetwork::create(*springs_of_sheet({.columns = 9, .rows = 9}));
    auto tissue = SpringTissue::create(*network, {.depth = 5});
    ASSERT_TRUE(tissue->hold(std::array{40}).ok());
    const Vec3d place = network->nodes()[40].rest + Vec3d{0, 0, 0.25};
    for (int n = 0; n < 10; ++n) {
        ASSERT_TRUE(tissue->shift_held({0, 0, 0.025}).ok());
        ASSERT_TRUE(tissue->step(3, one_thread()).ok());
    }
    EXPECT_LT(norm(tissue->position(40) - place), 1e-14);
    EXPECT_GT(tissue->displacement(41).z, 0);
}

}  // namespace
}  // namespace pliant::test
