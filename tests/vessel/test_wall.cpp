// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: vessel/centreline.cpp, vessel/ghost.cpp, vessel/region.cpp, vessel/surface.cpp,
// vessel/sweep.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh_files.h>
#include <pliant/models/vessel.h>
#include <pliant/scan_files.h>

#include <array>
#include <cmath>
#include <numbers>

#include "support/broken_volumes.h"
#include "support/random.h"

namespace pliant {
namespace {

constexpr double kPi = std::numbers::pi;

const TaskArena& arena() {
    static const TaskArena two(2);
    return two;
}

/// Invariants of every wall.
void expect_sound(const VesselWall& wall, std::int64_t euler, double least_dihedral = 10.7) {
    EXPECT_TRUE(check_mesh(wall.mesh).ok());
    const TetQuality q = tet_quality(wall.mesh);
    const Status sound = check_quality(q);
    EXPECT_TRUE(sound.ok()) << sound.error().message;
    EXPECT_EQ(q.pieces, 1);
    EXPECT_EQ(q.boundary.euler, euler);
    EXPECT_GE(q.min_dihedral_deg, least_dihedral);
    EXPECT_TRUE(check_cells(wall.ghost).ok());
    ASSERT_EQ(wall.ghost_positions.size(), wall.ghost.nodes_mm.size());
    for (std::size_t n = 0; n < wall.ghost_positions.size(); ++n) {
        double sum = 0;
        for (const double w : wall.ghost_positions[n].weights) sum += w;
        EXPECT_NEAR(sum, 1, 1e-12);
        EXPECT_LT(norm(position_of(wall.ghost_positions[n], wall.mesh) - wall.ghost.nodes_mm[n]),
                  1e-9);
    }
}

const Centreline kStraight{{{{{0, 0, 0}, 4}, {{0, 0, 20}, 4}}}};

TEST(WallAroundCentreline, OfAStraightTubeIsATube) {
    for (const int layers : {1, 2, 3}) {
        SCOPED_TRACE(layers);
        const auto wall =
            wall_around_centreline(kStraight, {.thickness_mm = 1.5, .layers = layers}, arena());
        ASSERT_TRUE(wall.ok()) << wall.error().message;
        expect_sound(*wall, 0);
        EXPECT_GE(wall->min_layers, layers);
        ASSERT_EQ(wall->ends.size(), 2u);
        const double volume = kPi * (5.5 * 5.5 - 16) * 20, lumen = kPi * 16 * 20;
        EXPECT_NEAR(tet_quality(wall->mesh).volume_mm3, volume, 0.03 * volume);
        // The ghost ends where the wall's rims begin to be rounded, within a cell of each end.
        EXPECT_NEAR(wall->lumen_mm3, lumen, 0.08 * lumen);
        EXPECT_EQ(surface_topology(wall->ghost).euler, 0);
        for (const Vec3d& p : wall->ghost.nodes_mm) EXPECT_NEAR(std::hypot(p.x, p.y), 4, 1e-6);
        // It faces the lumen.
        for (const auto& t : wall->ghost.cells) {
            const Vec3d a = wall->ghost.nodes_mm[std::size_t(t[0])],
                        b = wall->ghost.nodes_mm[std::size_t(t[1])],
                        c = wall->ghost.nodes_mm[std::size_t(t[2])];
            EXPECT_LT(dot(cross(b - a, c - a), Vec3d{a.x, a.y, 0}), 0);
        }
    }
}

TEST(WallAroundCentreline, ACoarserGhostRidesOnTheSameWall) {
    const auto wall = wall_around_centreline(kStraight, {.ghost_mm = 3}, arena());
    ASSERT_TRUE(wall.ok()) << wall.error().message;
    expect_sound(*wall, 0);
    const auto fine = wall_around_centreline(kStraight, {}, arena());
    EXPECT_EQ(wall->mesh.cells, fine->mesh.cells);
    EXPECT_LT(3 * wall->ghost.cells.size(), fine->ghost.cells.size());
    for (const Vec3d& p : wall->ghost.nodes_mm) EXPECT_NEAR(std::hypot(p.x, p.y), 4, 1e-6);
    for (const auto& t : wall->ghost.cells) {
        const Vec3d a = wall->ghost.nodes_mm[std::size_t(t[0])],
                    b = wall->ghost.nodes_mm[std::size_t(t[1])],
                    c = wall->ghost.nodes_mm[std::size_t(t[2])];
        EXPECT_LT(dot(cross(b - a, c - a), Vec3d{a.x, a.y, 0}), 0);
    }
}

TEST(WallAroundCentreline, ATreeIsOpenAtItsThreeTips) {
    // Told in both ways: as lines from the inlet to each outlet, and as parts that meet.
    const CentrePoint inlet{{0, 0, 0}, 4}, fork{{0, 0, 15}, 3.5}, left{{-10, 0, 30}, 2.5},
        right{{10, 1, 28}, 2.8};
    for (const Centreline& tree : {Centreline{{{inlet, fork, left}, {inlet, fork, right}}},
                                   Centreline{{{inlet, fork}, {fork, left}, {fork, right}}},
                                   Centreline{{{inlet, fork, left}, {fork, right}}}}) {
        const auto ends = ends_of(tree);
        ASSERT_EQ(ends.size(), 3u);
        EXPECT_EQ(ends[0].centre_mm, inlet.position_mm);
        EXPECT_EQ(ends[0].outward, (Vec3d{0, 0, -1}));
        const auto wall = wall_around_centreline(tree, {.thickness_mm = 1.2}, arena());
        ASSERT_TRUE(wall.ok()) << wall.error().message;
        expect_sound(*wall, -2);  // a ball with two handles
        EXPECT_GE(wall->min_layers, 2);
        EXPECT_EQ(surface_topology(wall->ghost).euler, -1);
    }
    const auto moved = ends_of(kStraight, 0.5);
    EXPECT_EQ(moved[1].centre_mm, (Vec3d{0, 0, 18}));
}

TEST(WallAroundCentreline, AConeHasTheRadiiBetween) {
    const Centreline cone{{{{{0, 0, 0}, 5}, {{0, 0, 20}, 3}}}};
    const auto wall = wall_around_centreline(cone, {.thickness_mm = 1}, arena());
    ASSERT_TRUE(wall.ok()) << wall.error().message;
    expect_sound(*wall, 0);
    // Spheres that shrink by a tenth touch a cone with that sine of the half angle.
    for (const Vec3d& p : wall->ghost.nodes_mm)
        if (p.z > 0.6) {
            EXPECT_NEAR((5 - p.z / 10) / std::sqrt(1 - 0.01), std::hypot(p.x, p.y), 1e-6);
        }
}

TEST(WallAroundSurface, OpenAndClosedSurfacesAndEndsThatCut) {
    // An open cylinder, its rims uneven, as clipping leaves them; in either orientation.
    TriangleMesh pipe;
    const int around = 40, rows = 21;
    for (int r = 0; r < rows; ++r)
        for (int s = 0; s < around; ++s) {
            const double a = 2 * kPi * s / around;
            const double z = r + (r == 0 || r == rows - 1 ? 0.3 * std::sin(5 * a) : 0);
            pipe.nodes_mm.push_back({3 * std::cos(a), 3 * std::sin(a), z});
        }
    for (int r = 0; r + 1 < rows; ++r)
        for (int s = 0; s < around; ++s) {
            const int a = r * around + s, b = r * around + (s + 1) % around;
            pipe.cells.push_back({a, b, b + around});
            pipe.cells.push_back({a, b + around, a + around});
        }
    TriangleMesh turned = pipe;
    for (auto& t : turned.cells) std::swap(t[0], t[1]);
    const auto wall = wall_around_surface(pipe, {}, {.thickness_mm = 1}, arena());
    ASSERT_TRUE(wall.ok()) << wall.error().message;
    expect_sound(*wall, 0);
    ASSERT_EQ(wall->ends.size(), 2u);
    EXPECT_NEAR(wall->ends[0].centre_mm.z, 0.3, 0.02);
    EXPECT_GT(wall->ends[1].outward.z, 0.999);
    const auto same = wall_around_surface(turned, {}, {.thickness_mm = 1}, arena());
    ASSERT_TRUE(same.ok()) << same.error().message;
    EXPECT_EQ(same->ends[1].centre_mm, wall->ends[1].centre_mm);
    EXPECT_NEAR(tet_quality(same->mesh).volume_mm3, tet_quality(wall->mesh).volume_mm3, 1);

    // A ball: closed without ends, a tube with two.
    const auto solid =
        stuff_isosurface([](Vec3d x) { return 6 - norm(x); },
                         {.begin_mm = {-7, -7, -7}, .end_mm = {7, 7, 7}, .cell_mm = 1}, arena());
    const TriangleMesh ball = boundary_triangles(*solid);
    const auto shell = wall_around_surface(ball, {}, {.thickness_mm = 1.5}, arena());
    ASSERT_TRUE(shell.ok()) << shell.error().message;
    expect_sound(*shell, 4);  // two spheres
    const double volume = 4.0 / 3 * kPi * (7.5 * 7.5 * 7.5 - 216);
    EXPECT_NEAR(tet_quality(shell->mesh).volume_mm3, volume, 0.03 * volume);
    const VesselEnd ends[] = {{{0, 0, 4}, {0, 0, 1}, 5}, {{0, 0, -4}, {0, 0, -1}, 5}};
    const auto drum = wall_around_surface(ball, ends, {.thickness_mm = 1.5}, arena());
    ASSERT_TRUE(drum.ok()) << drum.error().message;
    expect_sound(*drum, 0);
}

TEST(SweptTube, HasTheVolumeOfItsPolygonsAndFollowsBends) {
    const int sectors = 24;
    const auto tube = swept_tube(kStraight.branches[0], {.layers = 3, .sectors = sectors});
    ASSERT_TRUE(tube.ok()) << tube.error().message;
    expect_sound(*tube, 0);
    const double polygon = 0.5 * sectors * std::sin(2 * kPi / sectors) * 20;
    EXPECT_NEAR(tet_quality(tube->mesh).volume_mm3, polygon * (5.5 * 5.5 - 16), 1e-9);
    EXPECT_NEAR(tube->lumen_mm3, polygon * 16, 1e-9);
    EXPECT_EQ(surface_topology(tube->ghost).euler, 0);

    // A screw: as it bends both ways in space, frames that twist would show in the elements.
    std::vector<CentrePoint> screw;
    for (int n = 0; n <= 200; ++n) {
        const double a = 0.06 * n;
        screw.push_back({{12 * std::cos(a), 12 * std::sin(a), 2.5 * a}, 2 + 0.5 * std::sin(a)});
    }
    const auto bent = swept_tube(screw, {.thickness_mm = 0.8});
    ASSERT_TRUE(bent.ok()) << bent.error().message;
    expect_sound(*bent, 0, 15);
    for (auto& p : screw) p.radius_mm = 13;
    const auto folded = swept_tube(screw, {.thickness_mm = 0.8});
    ASSERT_FALSE(folded.ok());
    EXPECT_EQ(folded.error().message.find("vessel wall: the centreline bends too sharply"), 0u);
}

/// A tube through a scan from border to border, obliquely oriented, in a bath of other values.
Volume tube_scan(Vec3d* axis_mm) {
    Volume volume;
    volume.grid = {.size = {40, 36, 30}, .spacing_mm = {1, 1.1, 1.3}, .origin_mm = {5, -7, 11}};
    test::Random random(9);
    volume.grid.direction = random.rotation(true);
    std::vector<std::int16_t> values;
    for (int k = 0; k < 30; ++k)
        for (int j = 0; j < 36; ++j)
            for (int i = 0; i < 40; ++i) {
                const double r = std::hypot(i - 20.0, (j - 18) * 1.1);
                const bool island = i < 3 && j < 3;
                values.push_back(std::int16_t(r < 6 || island ? 300 : 40));
            }
    volume.voxels = std::move(values);
    *axis_mm = world_from_voxel(volume.grid, {20, 18, 15});
    return volume;
}

TEST(LumenOfRegion, IsTheTubeThroughTheScanAndOpenAtItsBorder) {
    Vec3d seed{};
    const Volume scan = tube_scan(&seed);
    const auto lumen = lumen_of_region(scan, {.seed_mm = seed, .low = 150, .high = 500}, arena());
    ASSERT_TRUE(lumen.ok()) << lumen.error().message;
    EXPECT_TRUE(check_closed(lumen->surface).ok());
    EXPECT_EQ(surface_topology(lumen->surface).euler, 2);
    const double volume = kPi * 36 * 30 * 1.3;
    EXPECT_NEAR(lumen->region_mm3, volume, 0.03 * volume);
    EXPECT_NEAR(enclosed_volume_mm3(lumen->surface), lumen->region_mm3, 0.03 * volume);
    ASSERT_EQ(lumen->ends.size(), 2u);
    for (const VesselEnd& end : lumen->ends)
        EXPECT_NEAR(std::abs(dot(end.outward, scan.grid.direction.columns[2])), 1, 1e-12);
    // Away from the border the surface is the cylinder, to a part of a voxel.
    for (const Vec3d& p : lumen->surface.nodes_mm) {
        const Vec3d ijk = voxel_from_world(scan.grid, p);
        if (ijk.z > 0.5 && ijk.z < 28.5) {
            EXPECT_NEAR(std::hypot(ijk.x - 20, (ijk.y - 18) * 1.1), 6, 0.6);
        }
    }
    const auto wall =
        wall_around_surface(lumen->surface, lumen->ends, {.thickness_mm = 2}, arena());
    ASSERT_TRUE(wall.ok()) << wall.error().message;
    expect_sound(*wall, 0);
    EXPECT_GE(wall->min_layers, 2);

    Volume labels = scan;
    const int wanted[] = {300};
    const auto same = lumen_of_labels(labels, wanted, 0.8, arena());
    ASSERT_TRUE(same.ok());
    EXPECT_EQ(same->surface.nodes_mm, lumen->surface.nodes_mm);
    const TaskArena one(1);
    const auto again = lumen_of_region(scan, {.seed_mm = seed, .low = 150, .high = 500}, one);
    EXPECT_EQ(again->surface.nodes_mm, lumen->surface.nodes_mm);
}

TEST(LumenOfRegion, ASeedBesideTheLumenIsRefused) {
    Vec3d seed{};
    const Volume scan = tube_scan(&seed);
    const auto complaint = [&](const RegionSettings& s) {
        const auto lumen = lumen_of_region(scan, s, arena());
        return lumen.ok() ? std::string() : lumen.error().message;
    };
    EXPECT_EQ(complaint({.seed_mm = seed, .low = 350, .high = 500}),
              "vessel wall: the scan's value at the seed is 300.000000, expected 350.000000 to "
              "500.000000");
    EXPECT_NE(complaint({.seed_mm = {500, 0, 0}, .low = 150, .high = 500})
                  .find("lies outside of the scan"),
              std::string::npos);
    EXPECT_EQ(complaint({.seed_mm = seed, .low = 5, .high = 5}),
              "vessel wall: the window is 5.000000 to 5.000000, expected low below high");
    const int none[] = {7};
    EXPECT_EQ(lumen_of_labels(scan, none, 0.8, arena()).error().message,
              "vessel wall: no voxel has one of the labels");
}

TEST(LumenOfRegion, StaysNearAWay) {
    Vec3d seed{};
    const Volume scan = tube_scan(&seed);
    const RegionSettings open{.seed_mm = seed, .low = 150, .high = 500};
    const auto whole = lumen_of_region(scan, open, arena());
    ASSERT_TRUE(whole.ok());
    // Every voxel within 9 mm of the piece of a line, and no other.
    RegionSettings settings = open;
    const Vec3d along = 6.0 * scan.grid.direction.columns[2];
    settings.way_mm = {seed - along, seed + along};
    settings.within_mm = 9;
    const auto near = lumen_of_region(scan, settings, arena());
    ASSERT_TRUE(near.ok()) << near.error().message;
    std::int64_t expected = 0;
    for (int k = 0; k < scan.grid.size.z; ++k)
        for (int j = 0; j < scan.grid.size.y; ++j)
            for (int i = 0; i < scan.grid.size.x; ++i) {
                const Vec3d x = world_from_voxel(scan.grid, {double(i), double(j), double(k)});
                double least = 1e300;
                for (int n = 0; n <= 1200; ++n)
                    least = std::min(least, norm(x - (seed + (n / 600.0 - 1) * along)));
                const float value = scan.at({i, j, k});
                expected += least <= 9 && value >= 150 && value <= 500;
            }
    EXPECT_EQ(near->voxels, expected);
    EXPECT_LT(near->voxels, whole->voxels);
    settings = open;
    settings.max_ml = 1;
    const auto leaks = lumen_of_region(scan, settings, arena());
    ASSERT_FALSE(leaks.ok());
    EXPECT_EQ(leaks.error().code, ErrorCode::LimitExceeded);
    EXPECT_NE(leaks.error().message.find("ml, expected at most 1: it leaks"), std::string::npos);
    settings.max_ml = 100;
    EXPECT_TRUE(lumen_of_region(scan, settings, arena()).ok());
}

TEST(VesselWall, RealAortasGetSoundWalls) {
    const std::filesystem::path data = PLIANT_SHARED_DATA;
    if (!std::filesystem::exists(data / "aorta_cta_1p5mm-label.nii.gz"))
        GTEST_SKIP() << "no shared data";
    const auto line = read_mesh(data / "aorta_centerline_vmtk.vtp");
    ASSERT_TRUE(line.ok()) << line.error().message;
    const auto centreline = centreline_of(*line);
    ASSERT_TRUE(centreline.ok()) << centreline.error().message;
    const auto surface = read_surface(data / "aorta_surface_segment1_vmtk.vtp");
    ASSERT_TRUE(surface.ok()) << surface.error().message;
    const auto ends = ends_of(*centreline, 0.5);
    ASSERT_EQ(ends.size(), 3u);
    const auto around = wall_around_surface(*surface, ends, {.ghost_mm = 1.5}, arena());
    ASSERT_TRUE(around.ok()) << around.error().message;
    expect_sound(*around, -2);
    EXPECT_GE(around->min_layers, 2);
    EXPECT_EQ(surface_topology(around->ghost).pieces, 1);
    EXPECT_EQ(surface_topology(around->ghost).euler, -1);
    const auto labels = read_volume(data / "aorta_cta_1p5mm-label.nii.gz");
    ASSERT_TRUE(labels.ok()) << labels.error().message;
    const int lumina[] = {1, 2};
    const auto lumen = lumen_of_labels(*labels, lumina, 1, arena());
    ASSERT_TRUE(lumen.ok()) << lumen.error().message;
    EXPECT_TRUE(check_closed(lumen->surface).ok());
    EXPECT_NEAR(enclosed_volume_mm3(lumen->surface), lumen->region_mm3, 0.03 * lumen->region_mm3);
    const auto wall =
        wall_around_surface(lumen->surface, lumen->ends, {.thickness_mm = 2}, arena());
    ASSERT_TRUE(wall.ok()) << wall.error().message;
    EXPECT_TRUE(check_quality(tet_quality(wall->mesh)).ok());
    EXPECT_GE(wall->min_layers, 2);
}

TEST(VesselWall, ThreadsDontChangeIt) {
    const TaskArena one(1), four(4);
    const auto a = wall_around_centreline(kStraight, {}, one);
    for (const TaskArena* threads : {&arena(), &four}) {
        const auto b = wall_around_centreline(kStraight, {}, *threads);
        EXPECT_EQ(a->mesh.cells, b->mesh.cells);
        EXPECT_EQ(a->mesh.nodes_mm, b->mesh.nodes_mm);
        EXPECT_EQ(a->ghost.nodes_mm, b->ghost.nodes_mm);
    }
}

TEST(VesselWall, WhatCantBeIsRefusedInOneLine) {
    const auto complaint = [](const auto& result) {
        return result.ok() ? std::string() : result.error().message;
    };
    EXPECT_EQ(complaint(wall_around_centreline(kStraight, {.thickness_mm = -1}, arena())),
              "vessel wall: thickness_mm: expected above 0 mm, found -1");
    EXPECT_EQ(complaint(wall_around_centreline(kStraight, {.layers = 0}, arena())),
              "vessel wall: layers: expected 1 to 16, found 0");
    EXPECT_EQ(complaint(wall_around_centreline({}, {}, arena())),
              "centreline: found no branches, expected one or more");
    EXPECT_EQ(complaint(wall_around_centreline({{{{{0, 0, 0}, 1}, {{0, 0, 1}, 0}}}}, {}, arena())),
              "centreline: branch 0, point 1: radius 0.000000 mm, expected a finite position and a "
              "radius above 0");
    TriangleMesh fin = boundary_triangles(hex_mesh({{2, 2, 2}}));
    fin.nodes_mm.push_back({5, 5, 5});
    fin.cells.push_back({fin.cells[0][0], fin.cells[0][1], 8});
    EXPECT_EQ(complaint(wall_around_surface(fin, {}, {}, arena())).find("vessel wall: the surface"),
              0u);
    EXPECT_EQ(complaint(swept_tube(kStraight.branches[0], {.sectors = 2})),
              "vessel wall: sectors is 2, expected 3 to 4096");
}

TEST(Lumen, AVolumeWithABrokenFieldIsRefusedAndLabelsMayBeAnyNumbers) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const test::BrokenVolume broken = test::broken_volume(random);
        const int one = 1;
        test::expect_refused(lumen_of_region(broken.volume, {.low = 0, .high = 1}, arena()),
                             "volume." + broken.field);
        test::expect_refused(lumen_of_labels(broken.volume, {&one, 1}, 0.8, arena()),
                             "labels." + broken.field);
        const Volume strange = test::volume_with_strange_values(random);
        const std::array wanted{-1, 0, INT32_MAX, INT32_MIN};
        (void)lumen_of_labels(strange, wanted, 0.8, arena());
    }
}

}  // namespace
}  // namespace pliant
