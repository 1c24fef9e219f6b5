// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: mesh/embed.cpp, mesh/tet_quality.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>

#include <cmath>
#include <numbers>

#include "support/random.h"

namespace pliant {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMinDihedral = 10.7, kLargestDihedral = 164.8;

const TaskArena& arena() {
    static const TaskArena two(2);
    return two;
}

StuffingSettings box(double half, double cell_mm) {
    StuffingSettings s;
    s.begin_mm = {-half, -half, -half};
    s.end_mm = {half, half, half};
    s.cell_mm = cell_mm;
    return s;
}

double ball(Vec3d x) {
    return 5 - norm(x);
}
double torus(Vec3d x) {
    return 1.5 - std::hypot(std::hypot(x.x, x.y) - 4, x.z);
}
/// A thick-walled tube with open ends.
double tube(Vec3d x) {
    const double r = std::hypot(x.x, x.y);
    return std::min({r - 2.5, 4 - r, 5 - std::abs(x.z)});
}

/// Waves about as long as a cell, in a ball: every pattern of signs and any place of cuts, which no
/// sensible solid would give.
LevelFunction noise(std::uint64_t seed) {
    test::Random random(seed);
    struct Wave {
        Vec3d k;
        double phase, size;
    };
    std::vector<Wave> waves;
    for (int n = 0; n < 12; ++n)
        waves.push_back({random.vector(4.5), random.real(0, 6.3), random.real(0.2, 1)});
    const double offset = random.real(-0.3, 0.7);
    return [waves, offset](Vec3d x) {
        double sum = offset;
        for (const Wave& w : waves) sum += w.size * std::sin(dot(w.k, x) + w.phase);
        return std::min(sum, 8.5 - norm(x));
    };
}

TEST(Stuffing, DihedralAnglesKeepToThePublishedBounds) {
    // [Labelle2007]. The noise comes within two degrees of the lower bound, so a wrong diagonal or
    // threshold shows.
    double least = 180;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const auto mesh = stuff_isosurface(noise(seed), box(9, 1), arena());
        ASSERT_TRUE(mesh.ok()) << mesh.error().message;
        const TetQuality q = tet_quality(*mesh);
        EXPECT_GT(q.tetrahedra, 5000);
        EXPECT_EQ(q.inverted, 0);
        EXPECT_EQ(q.non_manifold_faces, 0);
        EXPECT_EQ(q.boundary.open_edges, 0);
        EXPECT_GE(q.min_dihedral_deg, kMinDihedral);
        EXPECT_LE(q.largest_dihedral_deg, kLargestDihedral);
        least = std::min(least, q.min_dihedral_deg);
    }
    EXPECT_LT(least, kMinDihedral + 2);
}

TEST(Stuffing, VolumesConvergeAndTheBoundaryHasTheSolidsShape) {
    struct Case {
        const char* name;
        double (*level)(Vec3d);
        double half, volume;
        std::int64_t euler;
    };
    for (const Case& c : {Case{"ball", ball, 5.5, 4.0 / 3 * kPi * 125, 2},
                          Case{"torus", torus, 6, 2 * kPi * kPi * 4 * 1.5 * 1.5, 0},
                          Case{"tube", tube, 5.5, kPi * (16 - 6.25) * 10, 0}}) {
        SCOPED_TRACE(c.name);
        double before = 0;
        for (const double cell : {1.0, 0.5, 0.25}) {
            StuffingSettings s = box(c.half, cell);
            // Not a whole number of cells, so that no symmetry helps.
            s.begin_mm = s.begin_mm - Vec3d{0.13, 0.29, 0.41};
            const auto mesh = stuff_isosurface(c.level, s, arena());
            ASSERT_TRUE(mesh.ok()) << mesh.error().message;
            EXPECT_TRUE(check_mesh(*mesh).ok());
            const TetQuality q = tet_quality(*mesh);
            EXPECT_TRUE(check_quality(q).ok());
            EXPECT_EQ(q.pieces, 1);
            EXPECT_EQ(q.boundary.pieces, 1);
            EXPECT_EQ(q.boundary.euler, c.euler);
            EXPECT_GE(q.min_dihedral_deg, kMinDihedral);
            EXPECT_LE(q.largest_dihedral_deg, kLargestDihedral);
            const TriangleMesh surface = boundary_triangles(*mesh);
            EXPECT_TRUE(check_closed(surface).ok());
            EXPECT_NEAR(enclosed_volume_mm3(surface), q.volume_mm3, 1e-9 * c.volume);
            for (const Vec3d& p : surface.nodes_mm) EXPECT_LT(std::abs(c.level(p)), 1e-8);
            const double error = std::abs(q.volume_mm3 - c.volume) / c.volume;
            // Of second order where it is smooth; the tube's rounded rims are of second order too.
            if (before > 0) {
                EXPECT_LT(error, before / 2.5);
            }
            before = error;
        }
        EXPECT_LT(before, 0.005);
    }
}

TEST(Stuffing, ThreadsAndSkippingWhatIsFarDontChangeTheMesh) {
    StuffingSettings s = box(8, 0.4);
    const TaskArena one(1), four(4);
    const auto mesh = stuff_isosurface(torus, s, one);
    ASSERT_TRUE(mesh.ok());
    s.changes_as_distance = true;
    for (const TaskArena* threads : {&one, &arena(), &four}) {
        const auto same = stuff_isosurface(torus, s, *threads);
        ASSERT_TRUE(same.ok());
        EXPECT_EQ(same->cells, mesh->cells);
        EXPECT_EQ(same->nodes_mm, mesh->nodes_mm);
    }
    std::int64_t asked = 0;
    const auto counted = [&](Vec3d x) {
        ++asked;
        return torus(x);
    };
    ASSERT_TRUE(stuff_isosurface(counted, s, one).ok());
    EXPECT_LT(asked, 2 * 44 * 44 * 44 * 3 / 4);
}

TEST(Stuffing, WhatCantBeFilledIsRefusedInOneLine) {
    const auto complaint = [](const LevelFunction& level, const StuffingSettings& s) {
        const auto mesh = stuff_isosurface(level, s, arena());
        return mesh.ok() ? std::string() : mesh.error().message;
    };
    EXPECT_EQ(complaint(ball, box(5.5, 0)),
              "isosurface stuffing: cell_mm is 0.000000, expected a length above 0");
    EXPECT_EQ(complaint(ball, box(-1, 1)),
              "isosurface stuffing: the box ends before it begins along x");
    EXPECT_NE(complaint(ball, box(4, 1)).find("the solid reaches the box's border at"),
              std::string::npos);
    EXPECT_EQ(complaint([](Vec3d) { return -1.0; }, box(4, 1)),
              "isosurface stuffing: nothing is inside, expected a solid thicker than a cell");
    EXPECT_EQ(
        complaint([](Vec3d x) { return x.x > 0 ? NAN : -1.0; }, box(1, 1)),
        "isosurface stuffing: the function is not finite at (0.500000, -1.500000, -1.500000)");
    const auto huge = stuff_isosurface(ball, box(1e9, 1e-3), arena());
    ASSERT_FALSE(huge.ok());
    EXPECT_EQ(huge.error().code, ErrorCode::LimitExceeded);
    StuffingSettings s = box(5.5, 1);
    s.alpha_short = 0.5;
    EXPECT_EQ(complaint(ball, s),
              "isosurface stuffing: alpha_short is 0.500000, expected 0 to 0.5");
}

TEST(Embed, PointsRideOnTheirTetrahedra) {
    const auto mesh = stuff_isosurface(ball, box(5.5, 1), arena());
    ASSERT_TRUE(mesh.ok());
    test::Random random(5);
    std::vector<Vec3d> points;
    for (int n = 0; n < 300; ++n) points.push_back(random.vector(3.3));
    for (int n = 0; n < 50; ++n) points.push_back(5.2 * normalized(random.vector(1)));
    points.push_back(mesh->nodes_mm[7]);
    const auto embedded = embed(points, *mesh, arena());
    // The first tetrahedron that holds the point, found by looking at all.
    for (std::size_t n = 0; n < points.size(); ++n) {
        const Embedded& e = embedded[n];
        EXPECT_LT(norm(position_of(e, *mesh) - points[n]), 1e-12);
        const auto lowest = [&](std::size_t c) {
            const auto& cell = mesh->cells[c];
            const Vec3d a = mesh->nodes_mm[std::size_t(cell[0])];
            const Mat3d m{{mesh->nodes_mm[std::size_t(cell[1])] - a,
                           mesh->nodes_mm[std::size_t(cell[2])] - a,
                           mesh->nodes_mm[std::size_t(cell[3])] - a}};
            const Vec3d w = inverse(m) * (points[n] - a);
            return std::min({w.x, w.y, w.z, 1 - w.x - w.y - w.z});
        };
        std::int32_t holds = -1;
        for (std::size_t c = 0; c < mesh->cells.size() && holds < 0; ++c)
            if (lowest(c) >= -1e-9) holds = std::int32_t(c);
        if (holds >= 0)
            EXPECT_EQ(e.tetrahedron, holds);
        else
            EXPECT_LT(lowest(std::size_t(e.tetrahedron)), 0);
        if (norm(points[n]) < 4.7) {
            EXPECT_GE(holds, 0);
        }
        if (norm(points[n]) > 5.1) {
            EXPECT_LT(holds, 0);
        }
    }
    // They go where an affine map takes the mesh.
    TetMesh moved = *mesh;
    const Mat3d m{{{1.1, 0.2, 0}, {-0.1, 0.9, 0.3}, {0, 0.1, 1.2}}};
    for (Vec3d& p : moved.nodes_mm) p = m * p + Vec3d{1, 2, 3};
    for (std::size_t n = 0; n < points.size(); ++n)
        EXPECT_LT(norm(position_of(embedded[n], moved) - (m * points[n] + Vec3d{1, 2, 3})), 1e-11);
}

TEST(TetQuality, IsDescribedWhateverItsSize) {
    TetQuality q;
    q.volume_mm3 = 123456.75;
    EXPECT_NE(describe(q).find("volume              123456.8 mm3\n"), std::string::npos);
    q.volume_mm3 = -1e283;
    EXPECT_NE(describe(q).find("volume              -1.0e+283 mm3\n"), std::string::npos);
}

TEST(TetQuality, KnownTetrahedraHaveTheirKnownMeasures) {
    TetMesh regular{{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 2, 1, 3}}};
    TetQuality q = tet_quality(regular);
    EXPECT_EQ(q.inverted, 0);
    EXPECT_NEAR(q.volume_mm3, 8.0 / 3, 1e-12);
    EXPECT_NEAR(q.min_radius_ratio, 1, 1e-12);
    EXPECT_NEAR(q.min_dihedral_deg, 70.528779, 1e-6);
    EXPECT_NEAR(q.largest_dihedral_deg, 70.528779, 1e-6);
    EXPECT_EQ(q.boundary.euler, 2);
    EXPECT_TRUE(check_quality(q).ok());
    std::swap(regular.cells[0][0], regular.cells[0][1]);
    q = tet_quality(regular);
    EXPECT_NEAR(q.min_radius_ratio, -1, 1e-12);
    EXPECT_EQ(check_quality(q).error().message,
              "mesh: found 1 inverted or flat tetrahedra, expected none");
    // A cube's corner.
    const TetMesh corner{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
    q = tet_quality(corner);
    EXPECT_NEAR(q.min_dihedral_deg, 54.735610, 1e-6);
    EXPECT_NEAR(q.largest_dihedral_deg, 90, 1e-9);
    // 3 r / R with r = 1 / (3 + √3), R = √3 / 2.
    EXPECT_NEAR(q.min_radius_ratio, 3 / (3 + std::sqrt(3.0)) / (std::sqrt(3.0) / 2), 1e-12);
    // Two that share an edge only.
    TetMesh pair = corner;
    pair.nodes_mm.insert(pair.nodes_mm.end(), {{0, -1, 0}, {0, 0, -1}});
    pair.cells.push_back({0, 1, 4, 5});
    EXPECT_EQ(
        check_quality(tet_quality(pair)).error().message,
        "mesh: found 1 edges and nodes where the boundary touches itself, expected a manifold "
        "one");
}

}  // namespace
}  // namespace pliant
