// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Against the test of every node with every tetrahedron. Two vessels of the published size are
// case 15 of `./dev results pbd`.

#include <pliant/research/overlap.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/random.h"
#include "two_vessels.h"

namespace pliant::test {
namespace {

using results::add_vessel;
using results::all_pairs;

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
    add_vessel(mesh, random, 8, 1, 6, {0, 0, 0}, {});
    OverlapSearch search(mesh);
    std::vector<Vec3d> positions = mesh.nodes_mm;
    for (Vec3d& p : positions) p = p + random.vector(1);
    positions[3].x = std::numeric_limits<double>::quiet_NaN();
    positions[5] = {1e300, -1e300, 0};
    positions[9] = {1e5, 2e5, -3e5};
    // The cube of 1e300 overflows: points in such a tetrahedron are undecidable.
    const auto without_far = [&](std::span<const NodeInCell> all) {
        std::vector<NodeInCell> some;
        for (const NodeInCell& n : all) {
            const auto& cell = mesh.cells[std::size_t(n.cell)];
            if (std::count(cell.begin(), cell.end(), 5) == 0) some.push_back(n);
        }
        return some;
    };
    const auto expected = without_far(all_pairs(mesh, positions));
    EXPECT_EQ(without_far(search.find(positions)), expected);
    EXPECT_GT(expected.size(), 0U);
}

}  // namespace
}  // namespace pliant::test
