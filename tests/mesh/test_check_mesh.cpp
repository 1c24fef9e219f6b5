// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>
#include <pliant/mesh.h>

#include <algorithm>
#include <limits>
#include <string>

#include "support/random.h"

namespace pliant {
namespace {

const HexLattice kBlock{{3, 3, 3}};

std::string check_complaint(const auto& mesh) {
    const Status status = check_mesh(mesh);
    return status.ok() ? "" : status.error().message;
}

TEST(CheckMesh, RandomTurnsAndSmallShiftsOfNodesAreAccepted) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        HexMesh hexes = hex_mesh(kBlock);
        TetMesh tets = tet_mesh(kBlock);
        const Mat3d turn = random.rotation(false);
        for (std::size_t n = 0; n < hexes.nodes_mm.size(); ++n)
            hexes.nodes_mm[n] = tets.nodes_mm[n] = turn * (hexes.nodes_mm[n] + random.vector(0.15));
        EXPECT_EQ(check_complaint(hexes), "");
        EXPECT_EQ(check_complaint(tets), "");
    }
}

TEST(CheckMesh, AMirroredMeshIsInverted) {
    HexMesh hexes = hex_mesh(kBlock);
    TetMesh tets = tet_mesh(kBlock);
    for (auto* nodes : {&hexes.nodes_mm, &tets.nodes_mm})
        for (Vec3d& x : *nodes) x.z = -x.z;
    EXPECT_EQ(check_complaint(hexes),
              "mesh: cell 0 is inverted at a corner, expected a right-handed, convex one");
    EXPECT_EQ(check_complaint(tets),
              "mesh: cell 0 is inverted at a corner, expected a right-handed, convex one");
}

TEST(CheckMesh, OneCornerPushedThroughItsCellIsFound) {
    HexMesh mesh = hex_mesh(kBlock);
    mesh.nodes_mm[26] = {0.9, 0.9, 0.9};
    EXPECT_EQ(check_complaint(mesh),
              "mesh: cell 7 is inverted at a corner, expected a right-handed, convex one");
}

TEST(CheckMesh, BothSidesOfTheFlattestCorner) {
    const auto with_height = [](double h) {
        TetMesh tet{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
        tet.nodes_mm[3] = {1, 0, h};
        return tet;
    };
    EXPECT_EQ(check_complaint(with_height(2 * kFlattestCorner)), "");
    EXPECT_EQ(check_complaint(with_height(0.5 * kFlattestCorner)),
              "mesh: cell 0 is flat at a corner, expected a right-handed, convex one");
    TriangleMesh triangle{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}};
    EXPECT_EQ(check_complaint(triangle),
              "mesh: cell 0 is flat at a corner, expected a right-handed, convex one");
}

TEST(CheckMesh, NodesThatDoNotExistOrAreNotUsed) {
    HexMesh mesh = hex_mesh(kBlock);
    mesh.cells[5][2] = 27;
    EXPECT_EQ(check_complaint(mesh), "mesh: cell 5 names node 27, expected 0…26");
    mesh.cells[5][2] = -1;
    EXPECT_EQ(check_complaint(mesh), "mesh: cell 5 names node -1, expected 0…26");
    mesh = hex_mesh(kBlock);
    mesh.cells[0][1] = 0;
    EXPECT_EQ(check_complaint(mesh), "mesh: cell 0 names node 0 twice, expected distinct corners");
    mesh = hex_mesh(kBlock);
    mesh.nodes_mm.push_back({9, 9, 9});
    EXPECT_EQ(check_complaint(mesh), "mesh: node 27 belongs to no cell, expected each to be used");
    mesh.nodes_mm[3].x = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(check_complaint(mesh), "mesh: node 3 has a position that is not finite");
    EXPECT_EQ(check_complaint(HexMesh{}), "mesh: found no cells, expected one or more");
}

TEST(CheckMesh, PiecesAreCountedAndNamed) {
    HexMesh mesh = hex_mesh(kBlock);
    for (int copy = 1; copy < 3; ++copy) {
        const HexMesh other = hex_mesh({{2, 2, 2}, {1, 1, 1}, {10.0 * copy, 0, 0}});
        const auto first = std::int32_t(mesh.nodes_mm.size());
        mesh.nodes_mm.insert(mesh.nodes_mm.end(), other.nodes_mm.begin(), other.nodes_mm.end());
        auto cell = other.cells[0];
        for (auto& node : cell) node += first;
        mesh.cells.push_back(cell);
    }
    EXPECT_EQ(check_complaint(mesh),
              "mesh: node 27 is not connected to node 0 (there are 3 pieces), expected one piece");
    const auto piece = pieces(mesh);
    for (std::size_t n = 0; n < piece.size(); ++n) EXPECT_EQ(piece[n], n < 27 ? 0 : n < 35 ? 1 : 2);
}

TEST(CheckMesh, PiecesOfARandomNumberingAreThoseOfAFloodFill) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        TriangleMesh mesh;
        mesh.nodes_mm.resize(40);
        for (int t = 0; t < 14; ++t)
            mesh.cells.push_back({random.whole(0, 39), random.whole(0, 39), random.whole(0, 39)});
        std::vector<std::int32_t> flood(40, -1);
        std::int32_t count = 0;
        for (std::size_t start = 0; start < 40; ++start) {
            if (flood[start] >= 0) continue;
            flood[start] = count;
            for (bool grew = true; grew;) {
                grew = false;
                for (const auto& t : mesh.cells) {
                    const bool in = std::any_of(t.begin(), t.end(), [&](std::int32_t n) {
                        return flood[std::size_t(n)] == count;
                    });
                    for (const std::int32_t n : t)
                        if (in && flood[std::size_t(n)] < 0) {
                            flood[std::size_t(n)] = count;
                            grew = true;
                        }
                }
            }
            ++count;
        }
        EXPECT_EQ(pieces(mesh), flood);
    }
}

}  // namespace
}  // namespace pliant
