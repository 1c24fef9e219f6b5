// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: mesh/box_tree.cpp, mesh/surface_*.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/random.h"

namespace pliant {
namespace {

/// Winding number of the surface around a point: 1 inside, 0 outside. By solid angles, independent
/// of pseudonormals.
double winding_number(const TriangleMesh& s, Vec3d x) {
    double sum = 0;
    for (const auto& t : s.cells) {
        const Vec3d a = s.nodes_mm[std::size_t(t[0])] - x, b = s.nodes_mm[std::size_t(t[1])] - x,
                    c = s.nodes_mm[std::size_t(t[2])] - x;
        const double la = norm(a), lb = norm(b), lc = norm(c);
        sum += std::atan2(dot(a, cross(b, c)),
                          la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return sum / (2 * std::numbers::pi);
}

double segment_distance(Vec3d x, Vec3d a, Vec3d b) {
    const double t = std::clamp(dot(x - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
    return norm(x - (a + t * (b - a)));
}
/// To a triangle: its plane where the foot has weights above 0, else the nearest of three segments.
double triangle_distance(Vec3d x, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d n = normalized(cross(b - a, c - a));
    const Vec3d w = inverse(Mat3d{{b - a, c - a, n}}) * (x - a);
    if (w.x >= 0 && w.y >= 0 && w.x + w.y <= 1) return std::abs(w.z);
    return std::min(
        {segment_distance(x, a, b), segment_distance(x, b, c), segment_distance(x, c, a)});
}

/// Two lumps with a dent between them, and sharp creases where they meet.
TriangleMesh lumps() {
    const auto level = [](Vec3d x) {
        return std::max(3 - norm(x - Vec3d{-2, 0, 0}),
                        1.5 - std::max({std::abs(x.x - 2), std::abs(x.y), std::abs(x.z)}));
    };
    const TaskArena one(1);
    auto mesh = stuff_isosurface(
        level, {.begin_mm = {-6, -4, -4}, .end_mm = {4, 4, 4}, .cell_mm = 0.8}, one);
    EXPECT_TRUE(mesh.ok());
    return boundary_triangles(*mesh);
}

TEST(SurfaceDistance, IsThatOfEveryTriangleAndTheSignThatOfTheWindingNumber) {
    const TriangleMesh surface = lumps();
    const auto distance = SurfaceDistance::create(surface);
    ASSERT_TRUE(distance.ok()) << distance.error().message;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        int inside = 0;
        for (int n = 0; n < 600; ++n) {
            Vec3d x = random.vector(5);
            // Some straight off a node, where the sign hangs on the node's pseudonormal.
            if (n % 3 == 0)
                x = surface
                        .nodes_mm[std::size_t(random.whole(0, int(surface.nodes_mm.size()) - 1))] +
                    random.vector(0.05);
            double brute = 1e300;
            for (const auto& t : surface.cells)
                brute = std::min(brute, triangle_distance(x, surface.nodes_mm[std::size_t(t[0])],
                                                          surface.nodes_mm[std::size_t(t[1])],
                                                          surface.nodes_mm[std::size_t(t[2])]));
            const auto near = distance->nearest(x);
            EXPECT_NEAR(std::abs(near.distance_mm), brute, 1e-12);
            EXPECT_NEAR(norm(x - near.position_mm), std::abs(near.distance_mm), 1e-12);
            const bool is_inside = winding_number(surface, x) > 0.5;
            EXPECT_EQ(near.distance_mm < 0, is_inside);
            inside += is_inside;
            EXPECT_EQ(distance->nearest(x, brute + 1e-3).triangle, near.triangle);
            EXPECT_EQ(distance->nearest(x, 0.99 * brute).triangle, -1);
        }
        EXPECT_GT(inside, 80);
        EXPECT_LT(inside, 450);
    }
}

TEST(SurfaceTopology, SaysWhatIsOpenCrowdedAndPinched) {
    const TaskArena one(1);
    TriangleMesh cube = boundary_triangles(hex_mesh({{2, 2, 2}}));
    EXPECT_TRUE(check_closed(cube).ok());
    EXPECT_NEAR(enclosed_volume_mm3(cube), 1, 1e-15);
    EXPECT_TRUE(surface_topology(cube).closed_manifold());
    EXPECT_EQ(surface_topology(cube).euler, 2);

    TriangleMesh turned = cube;
    std::swap(turned.cells[3][0], turned.cells[3][1]);
    EXPECT_EQ(
        check_closed(turned).error().message,
        "surface: found 3 edges where the triangles face different ways, expected all to face "
        "outwards");
    TriangleMesh open = cube;
    open.cells.pop_back();
    EXPECT_EQ(check_closed(open).error().message,
              "surface: found 3 open edges, expected a closed surface");
    EXPECT_EQ(surface_topology(open).euler, 1);

    // Two cubes that share a node.
    TriangleMesh pair = cube;
    for (const auto& t : cube.cells) {
        auto other = t;
        for (std::int32_t& n : other) n = n == 0 ? 0 : n + 7;
        pair.cells.push_back(other);
    }
    for (std::size_t n = 1; n < 8; ++n)
        pair.nodes_mm.push_back(-cube.nodes_mm[n] + 2.0 * cube.nodes_mm[0]);
    const SurfaceTopology t = surface_topology(pair);
    EXPECT_EQ(t.pinched_nodes, 1);
    EXPECT_EQ(t.pieces, 1);
    EXPECT_EQ(t.euler, 3);

    // A fin on an edge.
    TriangleMesh fin = cube;
    fin.nodes_mm.push_back({5, 5, 5});
    fin.cells.push_back({fin.cells[0][0], fin.cells[0][1], 8});
    EXPECT_EQ(surface_topology(fin).non_manifold_edges, 1);
    EXPECT_FALSE(SurfaceDistance::create(fin).ok());
}

}  // namespace
}  // namespace pliant
