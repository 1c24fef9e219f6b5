// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Walls of given tetrahedra: the walls that the other functions make, without their knowledge.

#include <gtest/gtest.h>
#include <pliant/models/pbd.h>
#include <pliant/models/vessel.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "support/made.h"

namespace pliant::test {
namespace {

const TaskArena& workers() {
    static const TaskArena two(2);
    return two;
}

VesselWall swept(int sectors = 16) {
    std::vector<CentrePoint> way;
    for (int n = 0; n <= 12; ++n) {  // a U: the limbs' outer surfaces face each other
        const double angle = std::numbers::pi * n / 12;
        way.push_back({{15 * std::cos(angle), 0, 15 * std::sin(angle)}, 3});
    }
    return made(swept_tube(way, {.thickness_mm = 1, .layers = 2, .sectors = sectors}));
}

double area_of(const TriangleMesh& surface) {
    double area = 0;
    for (const auto& t : surface.cells) {
        const auto p = [&](std::size_t n) { return surface.nodes_mm[std::size_t(t[n])]; };
        area += 0.5 * norm(cross(p(1) - p(0), p(2) - p(0)));
    }
    return area;
}

/// @param round  share of the radius that a circle of the opening's area has
void expect_same(const VesselWall& given, const VesselWall& wall, double tolerance_mm,
                 double round) {
    EXPECT_TRUE(check_wall(given, wall.min_layers).ok());
    EXPECT_EQ(given.min_layers, wall.min_layers);
    EXPECT_NEAR(area_of(given.ghost), area_of(wall.ghost), 1e-9 * area_of(wall.ghost));
    EXPECT_NEAR(given.lumen_mm3, wall.lumen_mm3, 1e-9 * wall.lumen_mm3);
    ASSERT_EQ(given.ends.size(), wall.ends.size());
    for (const VesselEnd& end : wall.ends) {
        const auto found = std::min_element(
            given.ends.begin(), given.ends.end(), [&](const VesselEnd& a, const VesselEnd& b) {
                return norm(a.centre_mm - end.centre_mm) < norm(b.centre_mm - end.centre_mm);
            });
        EXPECT_LT(norm(found->centre_mm - end.centre_mm), tolerance_mm);
        EXPECT_GT(dot(found->outward, end.outward), 0.99);
        EXPECT_NEAR(found->radius_mm, round * end.radius_mm, tolerance_mm);
    }
    for (std::size_t n = 0; n < given.ghost_positions.size(); ++n)
        EXPECT_LT(norm(position_of(given.ghost_positions[n], given.mesh) - given.ghost.nodes_mm[n]),
                  1e-9);
}

TEST(WallOfMesh, FindsTheInnerSurfaceBetweenTheRims) {
    for (const int sectors : {7, 16}) {
        const VesselWall wall = swept(sectors);
        const double angle = 2 * std::numbers::pi / sectors;
        expect_same(made(wall_of_mesh(wall.mesh, {}, workers())), wall, 1e-6,
                    std::sqrt(std::sin(angle) / angle));
    }
}

TEST(WallOfMesh, TakesAnInnerSurfaceOfEitherOrientation) {
    const Centreline tree{{{{{0, 0, 0}, 4}, {{0, 0, 30}, 4}}, {{{0, 0, 14}, 3}, {{16, 0, 26}, 3}}}};
    const VesselWall wall = made(wall_around_centreline(tree, {}, workers()));
    TriangleMesh ghost = wall.ghost;
    expect_same(made(wall_of_mesh(wall.mesh, ghost, workers())), wall, wall.cell_mm, 1);
    for (auto& t : ghost.cells) std::swap(t[0], t[1]);
    expect_same(made(wall_of_mesh(wall.mesh, ghost, workers())), wall, wall.cell_mm, 1);
}

TEST(WallOfMesh, UnusedNodesAreLeftOut) {
    const VesselWall wall = swept();
    TetMesh mesh = wall.mesh;
    mesh.nodes_mm.push_back({0, 0, 0});
    EXPECT_EQ(made(wall_of_mesh(mesh, {}, workers())).mesh.nodes_mm, wall.mesh.nodes_mm);
}

TEST(WallOfMesh, SaysInOneLineWhyAMeshIsNoWall) {
    const VesselWall wall = swept();
    const auto after = [&](const std::function<void(TetMesh&, TriangleMesh&)>& change) {
        TetMesh mesh = wall.mesh;
        TriangleMesh lumen;
        change(mesh, lumen);
        const auto given = wall_of_mesh(mesh, lumen, workers());
        return given.ok() ? std::string() : given.error().message;
    };
    EXPECT_EQ(after([](TetMesh&, TriangleMesh&) {}), "");
    EXPECT_EQ(after([](TetMesh& m, TriangleMesh&) { m.cells.clear(); }),
              "vessel wall: it has no tetrahedra, expected one or more");
    const std::string inverted =
        after([](TetMesh& m, TriangleMesh&) { std::swap(m.cells[7][0], m.cells[7][1]); });
    EXPECT_NE(inverted.find("cell 7"), std::string::npos) << inverted;
    // One more tetrahedron that hangs on a node.
    const std::string pinched = after([](TetMesh& m, TriangleMesh&) {
        const std::int32_t a = boundary_faces(m)[0][0], b = std::int32_t(m.nodes_mm.size());
        for (const Vec3d by : {Vec3d{0, 5, 0}, Vec3d{0, 5, 1}, Vec3d{1, 5, 0}})
            m.nodes_mm.push_back(m.nodes_mm[std::size_t(a)] + by);
        m.cells.push_back({a, b, b + 1, b + 2});
    });
    EXPECT_EQ(pinched.find("vessel wall: "), 0u) << pinched;
    EXPECT_EQ(after([](TetMesh& m, TriangleMesh&) {
                  const auto count = std::int32_t(m.nodes_mm.size());
                  const TetMesh copy = m;
                  for (const Vec3d& p : copy.nodes_mm) m.nodes_mm.push_back(p + Vec3d{0, 50, 0});
                  for (auto c : copy.cells) {
                      for (auto& n : c) n += count;
                      m.cells.push_back(c);
                  }
              }),
              "vessel wall: it has 2 pieces, expected 1");
    const std::string block = after([](TetMesh& m, TriangleMesh&) {
        m = five_tet_block({4, 4, 4}, 1);
    });
    EXPECT_EQ(block.find("vessel wall: it is no tube: no part of its boundary between rims"), 0u)
        << block;
    // A block with a hollow in it.
    const std::string hollow = after([](TetMesh& m, TriangleMesh&) {
        m = five_tet_block({5, 5, 5}, 1);
        std::erase_if(m.cells, [&](const auto& cell) {
            Vec3d middle{0, 0, 0};
            for (const auto n : cell) middle = middle + 0.25 * m.nodes_mm[std::size_t(n)];
            return norm(middle - Vec3d{2.5, 2.5, 2.5}) < 1.2;
        });
    });
    EXPECT_EQ(hollow.find("vessel wall: "), 0u) << hollow;
    EXPECT_EQ(after([&](TetMesh&, TriangleMesh& lumen) {
                  lumen = wall.ghost;
                  lumen.cells.erase(lumen.cells.begin() + 100);
              }),
              "vessel wall: its inner surface has 3 openings, expected at most the 2 of its "
              "tetrahedra");
    const std::string closed = after([&](TetMesh&, TriangleMesh& lumen) {
        lumen = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                 {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
    });
    EXPECT_EQ(closed.find("vessel wall: it is no tube: its inner surface has 0 openings"), 0u)
        << closed;
    EXPECT_NE(after([&](TetMesh&, TriangleMesh& lumen) {
                  lumen = wall.ghost;
                  for (Vec3d& p : lumen.nodes_mm) p = p + Vec3d{0, 30, 0};
              }).find(" beside the wall, expected all on it"),
              std::string::npos);
}

}  // namespace
}  // namespace pliant::test
