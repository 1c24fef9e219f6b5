// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: springs/transmittal.cpp.

#include <pliant/models/springs.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "springs/random_networks.h"

namespace pliant::test {
namespace {

/// Distances by going over all links again and again.
std::vector<int> distances(const SpringNetwork& network, std::span<const std::int32_t> sources) {
    constexpr int kFar = 1 << 20;
    std::vector<int> distance(std::size_t(network.node_count()), kFar);
    for (const std::int32_t s : sources) distance[std::size_t(s)] = 0;
    for (bool changed = true; changed;) {
        changed = false;
        for (std::size_t l = 0; l < network.links().size(); ++l) {
            if (network.is_cut(l)) continue;
            const auto [a, b] = std::pair(network.links()[l].a, network.links()[l].b);
            for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
                if (network.nodes()[std::size_t(to)].fixed) continue;
                if (distance[std::size_t(from)] + 1 >= distance[std::size_t(to)]) continue;
                distance[std::size_t(to)] = distance[std::size_t(from)] + 1;
                changed = true;
            }
        }
    }
    return distance;
}

TEST(Order, LayersAreTheDistancesFromTheNearestSource) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        auto network = SpringNetwork::create(random_parts(random, random.whole(2, 200), false));
        ASSERT_TRUE(network.ok());
        std::vector<std::int32_t> cut;
        for (int n = 0; n < int(network->links().size()) / 5; ++n)
            cut.push_back(random.whole(0, int(network->links().size()) - 1));
        if (seed % 2 == 0) cut.clear();
        ASSERT_TRUE(network->cut_links(cut).ok());
        std::vector<std::int32_t> sources;
        for (int n = 0; n < 1 + int(seed % 4); ++n) {
            const int node = random.whole(0, network->node_count() - 1);
            if (!network->nodes()[std::size_t(node)].fixed) sources.push_back(node);
        }
        const int depth = random.whole(0, 12);
        const auto order = transmittal_order(*network, sources, depth);
        ASSERT_TRUE(order.ok());
        const std::vector<int> distance = distances(*network, sources);
        std::set<std::int32_t> seen;
        for (std::size_t l = 0; l + 1 < order->layers.size(); ++l)
            for (std::int32_t k = order->layers[l]; k < order->layers[l + 1]; ++k) {
                const std::int32_t node = order->nodes[std::size_t(k)];
                EXPECT_EQ(distance[std::size_t(node)], int(l));
                EXPECT_TRUE(seen.insert(node).second);
            }
        const auto within =
            std::count_if(distance.begin(), distance.end(), [&](int d) { return d <= depth; });
        EXPECT_EQ(seen.size(), std::size_t(within));
        EXPECT_EQ(order->nodes.size(), seen.size());
    }
}

// Test case 17 of the references: [Choi2004, Eq. 9 and 10], and Table 3.
TEST(Order, CountsAreThoseOfThePaper) {
    const auto sheet = SpringNetwork::create(*springs_of_sheet({.columns = 50, .rows = 50}));
    const auto count = [](const SpringNetwork& network, std::int32_t from, int depth) {
        return int(transmittal_order(network, std::array{from}, depth)->nodes.size());
    };
    const int table[8][2] = {{1, 7},  {2, 19},   {3, 37},   {4, 61},
                             {5, 91}, {10, 331}, {15, 721}, {20, 1261}};
    for (const auto& [depth, expected] : table)
        EXPECT_EQ(count(*sheet, 25 + 50 * 25, depth), expected);
    const auto block = SpringNetwork::create(
        *springs_of_lattice({.size = {25, 25, 13}, .links = LatticeLinks::Edges}));
    for (int n = 1; n <= 11; ++n)
        EXPECT_EQ(count(*block, 12 + 25 * 12, n), (n + 1) * (2 * n * n + 4 * n + 3) / 3);
}

TEST(Order, RegionsThatMeetShareTheirLayers) {
    auto network = SpringNetwork::create(
        *springs_of_lattice({.size = {9, 1, 1}, .links = LatticeLinks::Edges}));
    const auto order = transmittal_order(*network, std::array{1, 5}, 2);
    EXPECT_EQ(order->layers, (std::vector<std::int32_t>{0, 2, 6, 8}));
    std::set<std::int32_t> last(order->nodes.begin() + 6, order->nodes.end());
    EXPECT_EQ(last, (std::set<std::int32_t>{3, 7}));  // 3 is at distance two of both, once
}

TEST(Order, WhatCantBeASourceIsNamed) {
    auto parts = springs_of_sheet({.columns = 3, .rows = 3});
    parts->nodes[4].fixed = true;
    const auto network = SpringNetwork::create(std::move(*parts));
    EXPECT_EQ(transmittal_order(*network, std::array{9}, 2).error().message,
              "sources: expected nodes below 9, found 9");
    EXPECT_EQ(transmittal_order(*network, std::array{4}, 2).error().message,
              "sources: expected nodes that can move, found node 4, which is fixed");
    EXPECT_EQ(transmittal_order(*network, std::array{0}, -1).error().message,
              "depth: expected 0 layers or more, found -1");
}

}  // namespace
}  // namespace pliant::test
