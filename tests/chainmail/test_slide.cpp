// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A sphere along which tissue slides: touched tissue leaves it by the minimal distance.
// Covers: lattice/tool_touch.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "chainmail/chainmail_impl.h"
#include "chainmail/tissues.h"
#include "lattice/tool_touch.h"

namespace pliant::test {
namespace {

constexpr int kTissueHu = 40, kFloor = 20;
constexpr double kRadius_mm = 3;

/// A finger of three by three elements and ten high, on a floor.
Volume finger() {
    return volume_of({48, 32, 48}, [](Vec3i e) {
        const bool on_it = std::abs(e.x - 24) <= 1 && std::abs(e.y - 16) <= 1 && e.z > kFloor;
        return e.z <= kFloor || (on_it && e.z <= kFloor + 10) ? kTissueHu : int(kAirHu);
    });
}
constexpr Vec3i kTip{24, 16, kFloor + 10};

/// From above the finger's tip, at a distance beside its axis, down by 9 mm.
Push path_beside(double beside_mm) {
    return {.point_mm = {24 + beside_mm, 16, kFloor + 10 + kRadius_mm + 1},
            .push_mm = {0, 0, -9},
            .sphere_radius_mm = kRadius_mm};
}

std::int64_t tissue_inside(const ChainMail& tissue, Vec3d centre_mm) {
    const Grid& grid = tissue.volume().grid;
    std::int64_t inside = 0;
    for (int z = 0; z < grid.size.z; ++z)
        for (int y = 0; y < grid.size.y; ++y)
            for (int x = 0; x < grid.size.x; ++x) {
                const Vec3d rest = world_from_voxel(grid, {double(x), double(y), double(z)});
                const Vec3d away = rest + tissue.displacement_mm({x, y, z}) - centre_mm;
                inside += tissue.volume().at({x, y, z}) > -500 && norm(away) < kRadius_mm;
            }
    return inside;
}

TEST(Slide, ABumpIsBentAsideWhereAPushTakesTheWallAlong) {
    const Volume volume = finger();
    const TaskArena arena(2);
    // Each link of the finger yields by this fraction, so a tip that moves down by 8 mm moves the
    // wall below it down by 8 − 10·play, for any air.
    const double w = 1040 / 4095.0, play = 0.2 * (1 - w * w);
    for (const bool air : {false, true}) {
        ChainMailSettings settings;
        settings.air_enabled = air;
        ChainMail stuck = tissue_of(volume, arena, settings);
        ASSERT_TRUE(stuck.push_elements(std::vector<Vec3i>{kTip}, {0, 0, -8}).ok());
        EXPECT_NEAR(stuck.displacement_mm({24, 16, kFloor}).z, -(8 - 10 * play), 1e-4);

        ChainMail tissue = tissue_of(volume, arena, settings);
        const auto report = slide_sphere(tissue, path_beside(2));
        ASSERT_TRUE(report.ok());
        EXPECT_EQ(report->way_fraction, 1);
        EXPECT_EQ(report->limited_by, LimitedBy::None);
        EXPECT_GT(report->contacts, 2);
        const Vec3d tip = tissue.displacement_mm(kTip);
        EXPECT_LT(tip.x, -1) << "to the side";
        EXPECT_GT(tip.z, -3) << "and not down with the tool";
        EXPECT_GT(tissue.displacement_mm({24, 16, kFloor}).z, -1.1) << "the wall stays behind";
        EXPECT_NEAR(tip.y, 0, 1e-5);
    }
}

TEST(Slide, NothingIsLeftInsideAndNothingMovesWithoutContact) {
    const Volume volume = finger();
    const TaskArena arena(2);
    for (const double beside : {0.0, 0.5, 1.0, 2.0, 3.0, 4.5}) {
        SCOPED_TRACE(beside);
        ChainMail tissue = tissue_of(volume, arena);
        const Push path = path_beside(beside);
        const auto report = slide_sphere(tissue, path);
        ASSERT_TRUE(report.ok());
        EXPECT_EQ(report->way_fraction, 1);
        EXPECT_EQ(report->inside_elements, 0);
        EXPECT_EQ(tissue_inside(tissue, path.point_mm + path.push_mm), 0);
        EXPECT_LT(tissue.state().max_violation_mm, 1e-9);
        EXPECT_EQ(report->contacts > 0, beside < 4.1);  // 3 mm beside the element 1 mm off the axis
        EXPECT_EQ(tissue.state().moved_elements > 0, beside < 4.1);
    }
}

TEST(Slide, StraightOnItPushesAhead) {
    const Volume volume = volume_of({32, 32, 32}, [](Vec3i e) { return e.z < 16 ? 40 : -1000; });
    const TaskArena arena(2);
    ChainMail tissue = tissue_of(volume, arena);
    const auto report = slide_sphere(
        tissue, {.point_mm = {16, 16, 20}, .push_mm = {0, 0, -4}, .sphere_radius_mm = kRadius_mm});
    ASSERT_TRUE(report.ok());
    // The sphere ends at z = 16, so its lowest point is at 13. The surface at -500 HU is 540/1040
    // of a voxel above the last tissue element, and is sampled in steps of a sixteenth at most.
    const Vec3d u = tissue.displacement_mm({16, 16, 15});
    EXPECT_NEAR(u.z, -(2 + 540 / 1040.0), 1 / 16.0);
    EXPECT_NEAR(u.x, 0, 1e-5);
    EXPECT_NEAR(u.y, 0, 1e-5);
}

TEST(Slide, BoneEndsIt) {
    const Volume volume = volume_of({32, 32, 32}, [](Vec3i e) {
        return e.z < 13 ? 1000 : e.z < 16 ? kTissueHu : int(kAirHu);
    });
    const TaskArena arena(2);
    ChainMail tissue = tissue_of(volume, arena);
    const auto report = slide_sphere(
        tissue, {.point_mm = {16, 16, 20}, .push_mm = {0, 0, -8}, .sphere_radius_mm = kRadius_mm});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->limited_by, LimitedBy::Bone);
    EXPECT_GT(report->way_fraction, 1.48 / 8) << "the surface gives way";
    EXPECT_LT(report->way_fraction, 4.0 / 8);
    EXPECT_EQ(report->inside_elements, 0) << "where it has come to, not where it would have gone";
    EXPECT_EQ(report->end_mm, (Vec3d{16, 16, 20 - 8 * report->way_fraction}));
    EXPECT_EQ(tissue.displacement_mm({16, 16, 12}), (Vec3d{0, 0, 0}));
}

TEST(Slide, AToolBetweenTheVoxelsIsStopped) {
    // Bone beyond x = 12 voxels, in voxels and slices of many sizes.
    const TaskArena arena(1);
    for (const Vec3d h :
         {Vec3d{2, 2, 2}, Vec3d{0.8, 0.8, 5}, Vec3d{5, 0.8, 0.8}, Vec3d{0.02, 1, 3}})
        for (const double radius_mm : {0.1, 0.5, 1.3, 2.5}) {
            SCOPED_TRACE(testing::Message()
                         << h.x << " " << h.y << " " << h.z << ", " << radius_mm);
            Volume volume =
                volume_of({24, 16, 16}, [](Vec3i e) { return e.x < 12 ? -1000 : 1000; });
            volume.grid.spacing_mm = h;
            ChainMail tissue = tissue_of(volume, arena);
            const auto report = slide_sphere(tissue, {.point_mm = {2 * h.x, 7.5 * h.y, 7.5 * h.z},
                                                      .push_mm = {20 * h.x, 0, 0},
                                                      .sphere_radius_mm = radius_mm});
            ASSERT_TRUE(report.ok());
            EXPECT_EQ(report->limited_by, LimitedBy::Bone);
            EXPECT_LT(report->end_mm.x, 11.25 * h.x);
            EXPECT_EQ(tissue.state().moved_elements, 0);
        }
}

/// To one of 27 points of a cube around the origin.
Vec3d direction_to(int n) {
    const Vec3d d{n % 3 - 1.0, n / 3 % 3 - 1.0, n / 9 - 1.0};
    return norm(d) > 0 ? normalized(d) : d;
}

TEST(Slide, ABallWithinBoneEndsAtTheNearestFreePlace) {
    // Bone up to a plane beyond the ball's centre, across each direction to a cube's faces, edges
    // and corners. Places are tried in twelve shells up to the radius and a voxel: 4 mm.
    const TaskArena arena(1);
    for (int n = 0; n < 27; ++n) {
        const Vec3d across = direction_to(n);
        if (n == 13) continue;
        const Volume volume = volume_of({25, 25, 25}, [&](Vec3i e) {
            return dot(Vec3d{e.x - 12.0, e.y - 12.0, e.z - 12.0}, across) <= 1.9 ? 1000
                                                                                 : int(kAirHu);
        });
        ChainMail tissue = tissue_of(volume, arena);
        const auto report = slide_sphere(
            tissue,
            {.point_mm = {12, 12, 12}, .push_mm = {0, 0, -1}, .sphere_radius_mm = kRadius_mm});
        ASSERT_TRUE(report.ok());
        SCOPED_TRACE("direction " + std::to_string(n));
        const auto is_in_bone = [&](Vec3d mm) {
            return shows_tissue(lattice_of(tissue), volume, mm, {-500});
        };
        EXPECT_FALSE(is_in_bone(report->end_mm));
        const Vec3d way = report->end_mm - Vec3d{12, 12, 12};
        EXPECT_GT(dot(way, across), 0);
        const double shell = 3 * norm(way);
        EXPECT_NEAR(shell, std::round(shell), 1e-9);
        for (int nearer = 1; nearer < int(std::round(shell)); ++nearer)
            for (int m = 0; m < 27; ++m)
                EXPECT_TRUE(is_in_bone(Vec3d{12, 12, 12} + (nearer / 3.0) * direction_to(m)));
        EXPECT_FALSE(report->ends_in_tissue);
    }
}

TEST(Slide, TheSameBitsForEverySolverBrickSizeAndNumberOfThreads) {
    Random random(20261122);
    const double x = random.real(-3, 3), y = random.real(-3, 3);
    const Volume volume = finger();
    const Push path{
        .point_mm = {24 + x, 16 + y, 35}, .push_mm = {1, 0.5, -9}, .sphere_radius_mm = kRadius_mm};
    std::uint64_t expected = 0;
    for (const int threads : {1, 2, 4}) {
        const TaskArena arena(threads);
        ChainMailSettings settings;
        settings.brick_size = 4 + 2 * threads;
        settings.solver = threads == 4 ? ChainMailSolver::Heap : ChainMailSolver::Sweep;
        ChainMail tissue = tissue_of(volume, arena, settings);
        const auto report = slide_sphere(tissue, path);
        ASSERT_TRUE(report.ok());
        ASSERT_GT(report->contacts, 0);
        if (threads == 1) expected = tissue.hash();
        EXPECT_EQ(tissue.hash(), expected);
    }
}

TEST(Slide, IsOneStepOfTheHistoryAndScaledAsAPushIs) {
    const Volume volume = finger();
    const TaskArena arena(2);
    ChainMailSettings settings;
    ChainMail plain = tissue_of(volume, arena, settings);
    ASSERT_TRUE(slide_sphere(plain, path_beside(2)).ok());
    settings.scale = 4;
    ChainMail scaled = tissue_of(volume, arena, settings);
    Push quarter = path_beside(2);
    quarter.push_mm = 0.25 * quarter.push_mm;
    ASSERT_TRUE(slide_sphere(scaled, quarter).ok());
    EXPECT_EQ(scaled.hash(), plain.hash());
    EXPECT_EQ(plain.undo_steps(), 1);
    EXPECT_EQ(plain.next_undo_name(), "slide");
    ASSERT_TRUE(plain.undo().ok());
    EXPECT_EQ(plain.state().moved_elements, 0);
}

TEST(Slide, ABadPathIsRefusedAndChangesNothing) {
    const Volume volume = finger();
    const TaskArena arena(1);
    ChainMail tissue = tissue_of(volume, arena);
    std::vector<Push> bad(5, path_beside(2));
    bad[0].sphere_radius_mm = 0;
    bad[1].push_mm = {0, 0, 0};
    bad[2].push_mm.x = std::numeric_limits<double>::quiet_NaN();
    bad[3].push_mm = {0, 0, -40};
    bad[4].point_mm = {-1, 0, 0};
    for (const Push& path : bad) {
        const auto report = slide_sphere(tissue, path);
        ASSERT_FALSE(report.ok());
        EXPECT_EQ(report.error().code, ErrorCode::InvalidArgument);
        EXPECT_NE(report.error().message.find("expected"), std::string::npos);
        EXPECT_TRUE(report.error().message.starts_with("slide:")) << report.error().message;
    }
    EXPECT_EQ(tissue.undo_steps(), 0);
    EXPECT_EQ(tissue.state().moved_elements, 0);
}

TEST(Slide, AThinSphereMovesASurfaceAsFarAsItsLowestPoint) {
    const Volume volume = volume_of({24, 24, 32}, [](Vec3i e) { return e.z < 16 ? 40 : -1000; });
    const TaskArena arena(1);
    ChainMail tissue = tissue_of(volume, arena);
    constexpr double kThin_mm = 0.6;
    const auto report = slide_sphere(
        tissue, {.point_mm = {12, 12, 18}, .push_mm = {0, 0, -3}, .sphere_radius_mm = kThin_mm});
    ASSERT_TRUE(report.ok());
    // As above: the surface is at 15 + 540/1040, and the sphere ends at z = 15.
    const Vec3d u = tissue.displacement_mm({12, 12, 15});
    EXPECT_NEAR(u.z, -(kThin_mm + 540 / 1040.0), 1 / 16.0);
}

}  // namespace
}  // namespace pliant::test
