// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Force transmittal node by node: as SpringTissue with old positions, and what new ones change.

#include <gtest/gtest.h>
#include <pliant/research/springs.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "springs/random_networks.h"
#include "support/one_thread.h"

namespace pliant::test {
namespace {

constexpr SeenPositions kAll[] = {SeenPositions::Old, SeenPositions::NewLayers,
                                  SeenPositions::NewNodes};

OrderedTransmittal made(const SpringNetwork& network, std::int32_t source, std::int32_t depth,
                        SeenPositions seen, double step) {
    auto ordered = OrderedTransmittal::create(network, std::array{source}, depth, seen, step);
    EXPECT_TRUE(ordered.ok());
    return std::move(ordered).value();
}

std::int32_t movable_node(const SpringNetwork& network, Random& random) {
    for (;;) {
        const int node = random.whole(0, network.node_count() - 1);
        if (!network.nodes()[std::size_t(node)].fixed) return node;
    }
}

double difference(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double largest = 0;
    for (std::size_t n = 0; n < a.size(); ++n) largest = std::max(largest, norm(a[n] - b[n]));
    return largest;
}

TEST(OrderedTransmittal, OldPositionsMoveAsASpringTissueAndNewOnesOtherwise) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        SpringParts parts = seed % 3 ? random_parts(random, random.whole(20, 120), seed % 2)
                                     : random_block(random, {9, 5, 4}, 0.4, seed % 2);
        for (SpringNode& node : parts.nodes) node.damping += 0.5;
        const SpringNetwork network = *SpringNetwork::create(parts);
        const double step = 0.5 * stable_time_step(network, SeenPositions::NewNodes);
        ASSERT_GT(step, 0);
        const std::int32_t source = movable_node(network, random);
        const Vec3d force = random.vector(0.5);
        const int depth = random.whole(2, 6);
        auto tissue = SpringTissue::create(network, {.depth = depth, .time_step = step});
        ASSERT_TRUE(tissue->load(std::array{source}, std::array{force}).ok());
        ASSERT_TRUE(tissue->step(30, one_thread()).ok());
        std::vector<std::vector<Vec3d>> moved;
        for (const SeenPositions seen : kAll) {
            OrderedTransmittal ordered = made(network, source, depth, seen, step);
            ordered.load(source, force);
            ordered.step(30);
            moved.push_back(ordered.displacements());
        }
        EXPECT_LT(difference(moved[0], tissue->displacements()), 1e-11);
        EXPECT_GT(difference(moved[0], moved[1]), 1e-10);
        EXPECT_GT(difference(moved[0], moved[2]), 1e-10);
    }
}

/// A lattice whose nodes are numbered from one end or the other.
SpringNetwork lattice(bool backwards) {
    auto parts = springs_of_lattice({.size = {7, 7, 4}, .node_damping = 3});
    for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0;
    if (backwards) {
        std::reverse(parts->nodes.begin(), parts->nodes.end());
        const auto last = std::int32_t(parts->nodes.size()) - 1;
        for (SpringLink& link : parts->links) {
            link.a = last - link.a;
            link.b = last - link.b;
        }
        for (SpringCell& cell : parts->cells)
            for (std::int32_t& node : cell.nodes) node = last - node;
    }
    return *SpringNetwork::create(std::move(*parts));
}

// Which of a layer's nodes comes first, NewLayers leaves open and NewNodes doesn't.
TEST(OrderedTransmittal, TheOrderInALayerMattersForNewPositionsOfAllNodesOnly) {
    constexpr std::int32_t kSource = 3 + 7 * (3 + 7 * 3);
    for (const SeenPositions seen : kAll) {
        std::vector<std::vector<Vec3d>> moved;
        for (const bool backwards : {false, true}) {
            const SpringNetwork network = lattice(backwards);
            const std::int32_t source = backwards ? network.node_count() - 1 - kSource : kSource;
            OrderedTransmittal ordered = made(network, source, 5, seen, 0.05);
            ordered.load(source, {0.1, 0, -0.2});
            ordered.step(40);
            moved.push_back(ordered.displacements());
            if (backwards) std::reverse(moved.back().begin(), moved.back().end());
        }
        const double off = difference(moved[0], moved[1]);
        if (seen == SeenPositions::NewNodes)
            EXPECT_GT(off, 1e-6);
        else
            EXPECT_LT(off, 1e-12);
    }
}

// Test case 18 of the references.
TEST(OrderedTransmittal, AllEndInTheSameEquilibrium) {
    const SpringNetwork network = lattice(false);
    constexpr std::int32_t kSource = 3 + 7 * (3 + 7 * 3);
    auto tissue = SpringTissue::create(network, {.depth = 20});
    ASSERT_TRUE(tissue->load(std::array{kSource}, std::array{Vec3d{0.01, 0, -0.02}}).ok());
    ASSERT_TRUE(tissue->find_equilibrium().ok());
    for (const SeenPositions seen : kAll) {
        OrderedTransmittal ordered =
            made(network, kSource, 20, seen, 0.9 * stable_time_step(network, seen));
        ordered.load(kSource, {0.01, 0, -0.02});
        ordered.step(6000);
        EXPECT_LT(difference(ordered.displacements(), tissue->displacements()), 1e-8);
    }
    EXPECT_GT(norm(tissue->displacement(kSource)), 1e-3);
}

// Why SpringTissue has old positions: seen too early, a new one pushes along.
TEST(OrderedTransmittal, NewPositionsAddEnergyWhereOldOnesDont) {
    const SpringNetwork network = *SpringNetwork::create(*springs_of_lattice({.size = {6, 6, 6}}));
    EXPECT_EQ(stable_time_step(network, SeenPositions::NewNodes), 0);
    EXPECT_EQ(stable_time_step(network, SeenPositions::NewLayers), 0);
    EXPECT_EQ(stable_time_step(network, SeenPositions::Old), network.stable_time_step());
    // A drifting free block accelerates exponentially.
    const double step = 0.2 * network.stable_time_step();
    double speed[2];
    for (const int reading : {0, 1}) {
        OrderedTransmittal ordered =
            made(network, 0, 100, reading ? SeenPositions::NewNodes : SeenPositions::Old, step);
        double mass = 0;
        for (std::int32_t n = 0; n < network.node_count(); ++n) {
            ordered.set_state(n, network.nodes()[std::size_t(n)].rest, {1e-3, 0, 0});
            mass += network.nodes()[std::size_t(n)].mass;
        }
        ordered.step(40);
        speed[reading] = step * ordered.momentum().x / mass;
    }
    EXPECT_NEAR(speed[0], 1e-3, 1e-9);
    EXPECT_GT(speed[1], 2e-3);
}

TEST(OrderedTransmittal, StepsUpToTheBoundAreStable) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        SpringParts parts = seed % 2 ? random_parts(random, 60, seed % 4 == 1)
                                     : random_block(random, {6, 5, 4}, 3, seed % 4 == 2);
        for (SpringLink& link : parts.links) link.rest_length = -1;
        for (SpringNode& node : parts.nodes) node.damping += 0.2;
        const SpringNetwork network = *SpringNetwork::create(parts);
        for (const SeenPositions seen : kAll) {
            const double longest = stable_time_step(network, seen);
            ASSERT_GT(longest, 0);
            OrderedTransmittal ordered =
                made(network, movable_node(network, random), 100, seen, longest);
            double start = 0;
            for (std::int32_t n = 0; n < network.node_count(); ++n) {
                const SpringNode& node = network.nodes()[std::size_t(n)];
                if (node.fixed) continue;
                const Vec3d off = random.vector(1e-6);
                start = std::max(start, norm(off));
                ordered.set_state(n, node.rest + off, {0, 0, 0});
            }
            ordered.step(2000);
            for (const Vec3d moved : ordered.displacements()) EXPECT_LT(norm(moved), 1e3 * start);
        }
    }
}

TEST(OrderedTransmittal, BadInputIsRefused) {
    const SpringNetwork network = lattice(false);
    const auto refuses = [&](std::int32_t source, std::int32_t depth, double step) {
        return !OrderedTransmittal::create(network, std::array{source}, depth,
                                           SeenPositions::NewNodes, step)
                    .ok();
    };
    EXPECT_FALSE(refuses(100, 3, 0.1));
    EXPECT_TRUE(refuses(0, 3, 0.1));  // fixed
    EXPECT_TRUE(refuses(100, -1, 0.1));
    EXPECT_TRUE(refuses(100, 3, 0));
}

}  // namespace
}  // namespace pliant::test
