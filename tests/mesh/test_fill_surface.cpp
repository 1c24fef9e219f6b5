// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: mesh/make_manifold.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/random.h"

namespace pliant {
namespace {

const TaskArena kOne(1);

/// Surface of a level set.
TriangleMesh surface_of(const LevelFunction& level, double half_mm, double cell_mm) {
    auto mesh = stuff_isosurface(level,
                                 {.begin_mm = {-half_mm, -half_mm, -half_mm},
                                  .end_mm = {half_mm, half_mm, half_mm},
                                  .cell_mm = cell_mm},
                                 kOne);
    EXPECT_TRUE(mesh.ok()) << mesh.error().message;
    make_manifold(*mesh);
    return boundary_triangles(*mesh);
}

TriangleMesh ball(double radius_mm) {
    return surface_of([=](Vec3d x) { return radius_mm - norm(x); }, 1.2 * radius_mm,
                      0.1 * radius_mm);
}

TEST(FillSurface, FillsABallWithAboutAsManyTetrahedraAsWanted) {
    for (const std::int64_t wanted : {500, 5'000, 40'000}) {
        const auto solid = fill_surface(ball(30), {.tetrahedra = wanted}, kOne);
        ASSERT_TRUE(solid.ok()) << solid.error().message;
        const TetQuality q = tet_quality(solid->mesh);
        EXPECT_TRUE(check_quality(q).ok());
        EXPECT_GT(double(q.tetrahedra), 0.6 * double(wanted));
        EXPECT_LT(double(q.tetrahedra), 2.0 * double(wanted));
        EXPECT_GT(q.min_dihedral_deg, 10.7);
        EXPECT_LT(q.largest_dihedral_deg, 164.8);
        EXPECT_EQ(q.pieces, 1);
        EXPECT_EQ(q.boundary.euler, 2);
        EXPECT_NEAR(q.volume_mm3 / solid->surface_mm3, 1, wanted < 1000 ? 0.08 : 0.02) << wanted;
    }
}

TEST(FillSurface, BoundaryNodesLieOnTheSurface) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        SCOPED_TRACE(seed);
        test::Random random(seed);
        std::vector<Vec3d> centres;
        for (int n = 0; n < 4; ++n)
            centres.push_back({random.real(-6, 6), random.real(-6, 6), random.real(-6, 6)});
        const TriangleMesh lumps = surface_of(
            [&](Vec3d x) {
                double level = -1e9;
                for (const Vec3d& c : centres) level = std::max(level, 7 - norm(x - c));
                return level;
            },
            20, 1.1);
        const auto distance = SurfaceDistance::create(lumps);
        ASSERT_TRUE(distance.ok()) << distance.error().message;
        const auto solid = fill_surface(lumps, {.cell_mm = 1.7}, kOne);
        ASSERT_TRUE(solid.ok()) << solid.error().message;
        EXPECT_EQ(solid->cell_mm, 1.7);
        EXPECT_TRUE(check_quality(tet_quality(solid->mesh)).ok());
        std::vector<std::int32_t> nodes;
        (void)boundary_triangles(solid->mesh, &nodes);
        for (const std::int32_t n : nodes)
            EXPECT_LT(std::abs(distance->signed_mm(solid->mesh.nodes_mm[std::size_t(n)])),
                      solid->removed_cells ? 2 * 1.7 : 1e-6);
    }
}

TEST(FillSurface, TrianglesMayFaceInwards) {
    TriangleMesh inwards = ball(20);
    for (auto& t : inwards.cells) std::swap(t[1], t[2]);
    EXPECT_LT(enclosed_volume_mm3(inwards), 0);
    const auto solid = fill_surface(inwards, {.cell_mm = 4}, kOne);
    const auto same = fill_surface(ball(20), {.cell_mm = 4}, kOne);
    ASSERT_TRUE(solid.ok() && same.ok());
    EXPECT_GT(solid->surface_mm3, 0);
    EXPECT_EQ(solid->mesh.cells.size(), same->mesh.cells.size());
    EXPECT_NEAR(tet_quality(solid->mesh).volume_mm3, tet_quality(same->mesh).volume_mm3, 1e-6);
}

TEST(FillSurface, IsTheSameForAnyNumberOfThreads) {
    const auto one = fill_surface(ball(20), {.tetrahedra = 3000}, kOne);
    ASSERT_TRUE(one.ok());
    for (const int threads : {2, 5}) {
        const auto other = fill_surface(ball(20), {.tetrahedra = 3000}, TaskArena(threads));
        ASSERT_TRUE(other.ok());
        EXPECT_EQ(one->mesh.nodes_mm, other->mesh.nodes_mm);
        EXPECT_EQ(one->mesh.cells, other->mesh.cells);
    }
}

TEST(FillSurface, FaultsAreNamed) {
    const auto message = [](TriangleMesh surface, const FillSettings& settings) {
        const auto solid = fill_surface(std::move(surface), settings, kOne);
        return solid.ok() ? std::string("filled") : solid.error().message;
    };
    TriangleMesh open = ball(20);
    open.cells.pop_back();
    EXPECT_NE(message(open, {}).find("open"), std::string::npos) << message(open, {});
    EXPECT_NE(message(ball(20), {.cell_mm = -1}).find("cell_mm"), std::string::npos);
    EXPECT_NE(message(ball(20), {.tetrahedra = 3}).find("tetrahedra"), std::string::npos);
    EXPECT_NE(message(ball(20), {.cell_mm = 500}), "filled");
}

}  // namespace
}  // namespace pliant
