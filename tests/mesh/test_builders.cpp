// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: mesh/surface_topology.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>

#include <algorithm>
#include <map>
#include <set>

#include "support/random.h"
#include "support/triangle_sheet.h"

namespace pliant {
namespace {

HexLattice random_lattice(test::Random& random) {
    return {{random.whole(2, 6), random.whole(2, 6), random.whole(2, 6)},
            {random.real(0.3, 2), random.real(0.3, 2), random.real(0.3, 2)},
            random.vector(10)};
}

Vec3d extent_mm(const HexLattice& l) {
    return {(l.size.x - 1) * l.spacing_mm.x, (l.size.y - 1) * l.spacing_mm.y,
            (l.size.z - 1) * l.spacing_mm.z};
}

/// By the divergence theorem, from outward triangles.
double enclosed_volume(const TriangleMesh& mesh) {
    double sum = 0;
    for (const auto& t : mesh.cells) {
        const auto at = [&](std::size_t n) { return mesh.nodes_mm[std::size_t(t[n])]; };
        sum += dot(at(0), cross(at(1), at(2))) / 6;
    }
    return sum;
}

TEST(Builders, ALatticeOfHexahedraFillsItsBoxAndPassesTheCheck) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const HexLattice lattice = random_lattice(random);
        ASSERT_TRUE(check_lattice(lattice).ok());
        const HexMesh mesh = hex_mesh(lattice);
        ASSERT_TRUE(check_mesh(mesh).ok());
        EXPECT_EQ(std::int64_t(mesh.nodes_mm.size()), node_count(lattice));
        EXPECT_EQ(std::int64_t(mesh.cells.size()), cell_count(lattice));
        const Vec3d e = extent_mm(lattice);
        const TriangleMesh surface = boundary_triangles(mesh);
        EXPECT_TRUE(check_mesh(surface).ok());
        EXPECT_NEAR(enclosed_volume(surface), e.x * e.y * e.z, 1e-9 * e.x * e.y * e.z);
        const Vec3i c = lattice.size - Vec3i{1, 1, 1};
        EXPECT_EQ(boundary_faces(mesh).size(),
                  std::size_t(2 * (c.x * c.y + c.y * c.z + c.z * c.x)));
    }
}

TEST(Builders, TetrahedraOfALatticeFitTogetherAndFillIt) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const HexLattice lattice = random_lattice(random);
        const TetMesh mesh = tet_mesh(lattice);
        ASSERT_TRUE(check_mesh(mesh).ok());
        double volume = 0;
        std::map<std::set<std::int32_t>, int> faces;
        for (const auto& t : mesh.cells) {
            const auto at = [&](std::size_t n) { return mesh.nodes_mm[std::size_t(t[n])]; };
            volume += dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))) / 6;
            for (std::size_t left_out = 0; left_out < 4; ++left_out) {
                std::set<std::int32_t> face(t.begin(), t.end());
                face.erase(t[left_out]);
                ++faces[face];
            }
        }
        const Vec3d e = extent_mm(lattice);
        EXPECT_NEAR(volume, e.x * e.y * e.z, 1e-9 * volume);
        const Vec3i c = lattice.size - Vec3i{1, 1, 1};
        const auto single = std::count_if(faces.begin(), faces.end(),
                                          [](const auto& face) { return face.second == 1; });
        EXPECT_EQ(single, 4 * (c.x * c.y + c.y * c.z + c.z * c.x));
        for (const auto& [face, count] : faces) ASSERT_LE(count, 2);
    }
}

TEST(Builders, AnInnerNodeOfATriangleSheetHasSixNeighboursAtEqualDistance) {
    const int columns = 7, rows = 6;
    const TriangleMesh mesh = test::triangle_sheet(columns, rows, 2.5);
    ASSERT_TRUE(check_mesh(mesh).ok());
    std::vector<std::set<std::int32_t>> neighbours(mesh.nodes_mm.size());
    for (const auto& t : mesh.cells) {
        const Vec3d a = mesh.nodes_mm[std::size_t(t[0])];
        EXPECT_GT(
            cross(mesh.nodes_mm[std::size_t(t[1])] - a, mesh.nodes_mm[std::size_t(t[2])] - a).z, 0);
        for (const std::int32_t p : t)
            for (const std::int32_t q : t)
                if (p != q) {
                    neighbours[std::size_t(p)].insert(q);
                    EXPECT_NEAR(norm(mesh.nodes_mm[std::size_t(p)] - mesh.nodes_mm[std::size_t(q)]),
                                2.5, 1e-12);
                }
    }
    for (int j = 1; j + 1 < rows; ++j)
        for (int i = 1; i + 1 < columns; ++i)
            EXPECT_EQ(neighbours[std::size_t(i + columns * j)].size(), 6u);
}

TEST(Builders, FacesLookOutward) {
    const HexMesh mesh = hex_mesh({});
    const Vec3d outward[6] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    for (int f = 0; f < 6; ++f) {
        const auto at = [&](int n) {
            return mesh.nodes_mm[std::size_t(mesh.cells[0][std::size_t(kHexFaceCorners[f][n])])];
        };
        EXPECT_EQ(cross(at(1) - at(0), at(3) - at(0)), outward[f]) << f;
    }
}

TEST(Builders, ALatticeThatCannotBeNamesItsField) {
    HexLattice lattice{{2, 1, 2}};
    EXPECT_EQ(check_lattice(lattice).error().message,
              "lattice: size.y is 1, expected 2 nodes or more");
    lattice = {{2, 2, 2}, {1, 1, -3}};
    EXPECT_EQ(check_lattice(lattice).error().message,
              "lattice: spacing_mm.z is -3.000000, expected a length above 0");
    lattice = {{2000, 2000, 2000}};
    EXPECT_EQ(check_lattice(lattice).error().code, ErrorCode::LimitExceeded);
}

}  // namespace
}  // namespace pliant
