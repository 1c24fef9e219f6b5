// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Against the test of every node with every tetrahedron.

#include <pliant/mesh_overlap.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "support/random.h"

namespace pliant::test {
namespace {

/// Without a box around the tetrahedron, so that nothing is left out by it.
std::vector<NodeInCell> all_pairs(const TetMesh& mesh, std::span<const Vec3d> places) {
    std::vector<NodeInCell> found;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const auto& cell = mesh.cells[c];
        const Vec3d o = places[std::size_t(cell[0])];
        Mat3d edges{};
        for (std::size_t n = 0; n < 3; ++n) edges.columns[n] = places[std::size_t(cell[n + 1])] - o;
        if (!(std::abs(determinant(edges)) > 0)) continue;
        const Mat3d inverse = pliant::inverse(edges);
        for (std::size_t n = 0; n < places.size(); ++n) {
            const Vec3d beta = inverse * (places[n] - o);
            if (beta.x >= 0 && beta.y >= 0 && beta.z >= 0 && beta.x + beta.y + beta.z <= 1 &&
                std::count(cell.begin(), cell.end(), std::int32_t(n)) == 0)
                found.push_back({std::int32_t(c), std::int32_t(n)});
        }
    }
    return found;
}

/// A vessel along z of hexahedra, six tetrahedra each; its nodes are a little off their places.
void add_vessel(TetMesh& mesh, Random& random, int around, int across, int along, Vec3d middle,
                const Mat3d& turn) {
    const auto first = std::int32_t(mesh.nodes_mm.size());
    for (int k = 0; k <= along; ++k)
        for (int r = 0; r <= across; ++r)
            for (int a = 0; a < around; ++a) {
                const double radius = 4 + 2.0 * r / across;
                const double angle = 2 * std::numbers::pi * a / around;
                const Vec3d p{radius * std::cos(angle), radius * std::sin(angle), k - 0.5 * along};
                mesh.nodes_mm.push_back(middle + turn * (p + random.vector(0.05)));
            }
    const auto node = [&](int r, int a, int k) {
        return first + a % around + around * (r + (across + 1) * k);
    };
    constexpr int kPaths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int k = 0; k < along; ++k)
        for (int r = 0; r < across; ++r)
            for (int a = 0; a < around; ++a)
                for (const auto& path : kPaths) {
                    int at[3] = {r, a, k};
                    std::array<std::int32_t, 4> cell{node(at[0], at[1], at[2])};
                    for (std::size_t n = 0; n < 3; ++n) {
                        ++at[path[n]];
                        cell[n + 1] = node(at[0], at[1], at[2]);
                    }
                    mesh.cells.push_back(cell);
                }
}

// Case 15, the fourth set of [Teschner2003]: two vessels of 20514 tetrahedra and 5898 nodes.
TEST(Overlap, TwoVesselsOfThePublishedSizeMeetAsEveryNodeWithEveryTetrahedron) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        TetMesh mesh;
        add_vessel(mesh, random, 23, 1, 56, {0, 0, 0}, kIdentity3);
        add_vessel(mesh, random, 26, 2, 41, random.vector(3), random.rotation(false));
        mesh.cells.resize(20514);  // of 20520
        ASSERT_EQ(mesh.nodes_mm.size(), 5898U);
        OverlapSearch search(mesh);
        for (const double moved : {0.0, 0.3}) {  // a second search in the same table
            std::vector<Vec3d> places = mesh.nodes_mm;
            for (Vec3d& p : places) p = p + random.vector(moved);
            const auto found = search.find(places);
            const auto expected = all_pairs(mesh, places);
            std::printf("vessels %d, moved %.1f: %zu pairs\n", int(seed), moved, expected.size());
            EXPECT_GT(expected.size(), 100U);
            EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
        }
    }
}

TEST(Overlap, WhatIsOnABoundaryIsInsideAndNodesOfATetrahedronAreNot) {
    // A tetrahedron, and nodes at its corner, on its edge, on its face, inside, and just outside.
    const double out = -1e-12;
    TetMesh mesh{{{0, 0, 0},
                  {1, 0, 0},
                  {0, 1, 0},
                  {0, 0, 1},
                  {1, 0, 0},
                  {0.5, 0.5, 0},
                  {0.25, 0.25, 0.5},
                  {0.1, 0.1, 0.1},
                  {out, 0.1, 0.1},
                  {0.5, 0.5, 0.01}},
                 {{0, 1, 2, 3}}};
    OverlapSearch search(mesh);
    const std::vector<NodeInCell> expected{{0, 4}, {0, 5}, {0, 6}, {0, 7}};
    auto found = search.find(mesh.nodes_mm);
    EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
    std::swap(mesh.nodes_mm[1], mesh.nodes_mm[2]);  // inverted
    found = search.find(mesh.nodes_mm);
    EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
    mesh.nodes_mm[3] = {1, 1, 0};  // flat
    EXPECT_TRUE(search.find(mesh.nodes_mm).empty());
}

TEST(Overlap, PlacesThatAreFarAwayOrNoNumbersDoNoHarm) {
    Random random(7);
    TetMesh mesh;
    add_vessel(mesh, random, 8, 1, 6, {0, 0, 0}, kIdentity3);
    OverlapSearch search(mesh);
    std::vector<Vec3d> places = mesh.nodes_mm;
    for (Vec3d& p : places) p = p + random.vector(1);
    places[3].x = std::numeric_limits<double>::quiet_NaN();
    places[5] = {1e300, -1e300, 0};
    places[9] = {1e5, 2e5, -3e5};
    // 1e300 to the third power is no number: what such a tetrahedron holds can't be told.
    const auto without_far = [&](std::span<const NodeInCell> all) {
        std::vector<NodeInCell> some;
        for (const NodeInCell& n : all) {
            const auto& cell = mesh.cells[std::size_t(n.cell)];
            if (std::count(cell.begin(), cell.end(), 5) == 0) some.push_back(n);
        }
        return some;
    };
    const auto expected = without_far(all_pairs(mesh, places));
    EXPECT_EQ(without_far(search.find(places)), expected);
    EXPECT_GT(expected.size(), 0U);
}

}  // namespace
}  // namespace pliant::test
