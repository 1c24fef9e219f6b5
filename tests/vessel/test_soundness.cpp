// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Sound and unsound walls. For any cells the inner surface is the lumen's, open at its ends only,
// or the wall is refused in a line with the reason.
// Covers: vessel/openings.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/vessel.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>

#include "support/made.h"
#include "support/random.h"
#include "vessel/wall.h"

namespace pliant::test {
namespace {

const TaskArena& arena() {
    static const TaskArena shared(2);
    return shared;
}

/// A straight trunk and a branch, of random sizes.
Centreline random_tree(Random& random) {
    const double trunk = random.real(3, 6), side = random.real(2, 0.8 * trunk + 1);
    const double length = random.real(24, 36), angle = random.real(1.4, 1.8);
    const Vec3d fork{0, 0, 0.5 * length};
    const double reach = random.real(4, 5) * trunk;
    const Vec3d tip = fork + reach * Vec3d{std::sin(angle), 0, std::cos(angle)};
    return {{{{{0, 0, 0}, trunk}, {fork, trunk}, {{0, 0, length}, random.real(0.7, 1) * trunk}},
             {{fork, side}, {tip, side}}}};
}

/// Distance from the nearest sphere of the branches: the lumen's surface is where it is 0.
double outside_of(const Centreline& tree, Vec3d p) {
    double least = 1e9;
    for (const auto& branch : tree.branches)
        for (std::size_t n = 1; n < branch.size(); ++n)
            for (int k = 0; k <= 2000; ++k) {
                const double t = k / 2000.0;
                const Vec3d middle =
                    (1 - t) * branch[n - 1].position_mm + t * branch[n].position_mm;
                const double radius = (1 - t) * branch[n - 1].radius_mm + t * branch[n].radius_mm;
                least = std::min(least, norm(p - middle) - radius);
            }
    return least;
}

TEST(VesselWall, ItsInnerSurfaceIsTheLumensWhateverTheCells) {
    int refined = 0, as_wanted = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Centreline tree = random_tree(random);
        WallSettings settings{.thickness_mm = random.real(1, 2)};
        settings.cell_mm = settings.thickness_mm * random.real(0.4, 1.5);
        const VesselWall wall = made(wall_around_centreline(tree, settings, arena()));
        (wall.refined_because.empty() ? as_wanted : refined) += 1;
        EXPECT_LE(wall.cell_mm, settings.cell_mm);
        EXPECT_EQ(wall.refined_because.empty(), wall.cell_mm == settings.cell_mm);
        // Apart from check_wall: closed with as many lids as there are ends, and the lumen's.
        ASSERT_EQ(wall.ends.size(), 3u);
        const SurfaceTopology ghost = surface_topology(wall.ghost);
        EXPECT_EQ(ghost.pieces, 1);
        EXPECT_EQ(ghost.euler, -1);  // a sphere with three holes
        EXPECT_EQ(made(vessel::openings_of(wall.ghost)).size(), 3u);
        const TriangleMesh closed = made(vessel::with_lids(wall.ghost));
        EXPECT_TRUE(check_closed(closed).ok());
        // At a sharp edge of the lumen a cell may be lost: there the surface is inside of it.
        std::size_t inside = 0;
        for (const Vec3d& p : wall.ghost.nodes_mm) {
            const double outside = outside_of(tree, p);
            ASSERT_LE(outside, 1e-3) << p.x << ", " << p.y << ", " << p.z;
            ASSERT_GE(outside, -0.5 * wall.cell_mm) << p.x << ", " << p.y << ", " << p.z;
            inside += outside < -1e-3;
        }
        EXPECT_LE(100 * inside, wall.ghost.nodes_mm.size());
        for (const auto& branch : tree.branches)
            EXPECT_TRUE(
                vessel::is_inside(closed, 0.5 * (branch[0].position_mm + branch[1].position_mm)));
        const TetQuality quality = tet_quality(wall.mesh);
        EXPECT_EQ(quality.pieces, 1);
        EXPECT_EQ(quality.inverted, 0);
        EXPECT_GE(wall.min_layers, 2);
    }
    EXPECT_GT(refined, 0);
    std::printf("%d walls as wanted, %d refined\n", as_wanted, refined);
}

std::string complaint(const VesselWall& wall, int layers = 1) {
    const Status status = check_wall(wall, layers);
    return status.ok() ? std::string() : status.error().message;
}

TEST(CheckWall, SaysWhichFaultItFound) {
    const Centreline tube{{{{{0, 0, 0}, 4}, {{0, 0, 20}, 4}}}};
    const VesselWall good = made(wall_around_centreline(tube, {}, arena()));
    EXPECT_EQ(complaint(good, 2), "");
    const auto after = [&](const std::function<void(VesselWall&)>& change, int layers = 1) {
        VesselWall wall = good;
        change(wall);
        return complaint(wall, layers);
    };
    EXPECT_EQ(after([](VesselWall& w) { w.ghost.cells.erase(w.ghost.cells.begin() + 300); }),
              "vessel wall: its inner surface has 3 openings, expected 2, one at each end of the "
              "vessel");
    EXPECT_EQ(after([](VesselWall& w) { w.ends.pop_back(); }),
              "vessel wall: its inner surface has 2 openings, expected 1, one at each end of the "
              "vessel");
    EXPECT_EQ(after([](VesselWall& w) { w.min_layers = 1; }, 2),
              "vessel wall: 1 layer of tetrahedra across it, expected 2 or more");
    EXPECT_EQ(after([](VesselWall& w) {
                  w.ghost.cells.push_back(w.ghost.cells[0]);
              }).find("vessel wall: its inner surface branches or touches itself in "),
              0u);
    EXPECT_EQ(after([](VesselWall& w) {
                  w.ghost_positions.pop_back();
              }).find("vessel wall: ghost_positions: expected "),
              0u);
    EXPECT_EQ(after([](VesselWall& w) {
                  for (Vec3d& p : w.ghost.nodes_mm) p = p + Vec3d{0, 0, p.z > 18 ? 9.0 : 0.0};
              }).find(" beside the wall, expected all on it") != std::string::npos,
              true);
    // Cut in two: the wall, and the inner surface.
    EXPECT_NE(after([](VesselWall& w) {
                  std::erase_if(w.mesh.cells, [&](const auto& cell) {
                      const double z = w.mesh.nodes_mm[std::size_t(cell[0])].z;
                      return z > 8 && z < 12;
                  });
              }),
              "");
    EXPECT_EQ(after([](VesselWall& w) {
                  std::erase_if(w.ghost.cells, [&](const auto& cell) {
                      const double z = w.ghost.nodes_mm[std::size_t(cell[0])].z;
                      return z > 8 && z < 12;
                  });
              }),
              "vessel wall: its inner surface has 2 pieces, expected 1");
    EXPECT_EQ(after([](VesselWall& w) { w.mesh.cells.clear(); }),
              "mesh: found no cells, expected one or more");
}

TEST(VesselWall, CellsThatDontCarryAnAortaAreRefined) {
    const std::filesystem::path data = PLIANT_SHARED_DATA;
    if (!std::filesystem::exists(data / "aorta_surface_segment1_vmtk.vtp"))
        GTEST_SKIP() << "no shared data";
    const auto surface = made(read_surface(data / "aorta_surface_segment1_vmtk.vtp"));
    const auto line = made(read_mesh(data / "aorta_centerline_vmtk.vtp"));
    const auto ends = ends_of(made(centreline_of(line)), 0.5);
    const VesselWall wall =
        made(wall_around_surface(surface, ends, {.thickness_mm = 1.5, .cell_mm = 1.6}, arena()));
    EXPECT_NE(wall.refined_because, "");
    EXPECT_LT(wall.cell_mm, 1);
    EXPECT_EQ(complaint(wall, 2), "");
    EXPECT_EQ(made(vessel::openings_of(wall.ghost)).size(), 3u);
}

// A wall with branches so near to each other that they merge is valid too.
TEST(VesselWall, BranchesMayGrowTogetherOutside) {
    const double r = 12, gap = 1.2;
    std::vector<CentrePoint> ring;
    for (int n = 0; n <= 40; ++n) {
        const double a = 2 * std::numbers::pi * (0.02 + 0.96 * n / 40);
        ring.push_back({{r * std::cos(a), r * std::sin(a), 0.05 * n}, 2});
    }
    // Its two ends are beside each other, and so are their walls.
    ring.front().position_mm = ring.front().position_mm + Vec3d{0, gap, 0};
    ring.back().position_mm = ring.back().position_mm + Vec3d{0, -gap, 4};
    const auto wall = wall_around_centreline({{ring}}, {.thickness_mm = 1.5}, arena());
    ASSERT_TRUE(wall.ok()) << wall.error().message;
    EXPECT_EQ(complaint(*wall, 2), "");
}

}  // namespace
}  // namespace pliant::test
