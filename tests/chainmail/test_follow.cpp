// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Motions that follow a field: valid link by link, zero at bone, and those of plain loops.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <random>
#include <vector>

#include "chainmail/tissues.h"

namespace pliant::test {
namespace {

std::uint64_t seed_of_follow() {
    const std::uint64_t seed = std::random_device()();
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    return seed;
}

/// Noise with some bone, on a rotated grid.
Volume random_scan(Random& random) {
    Volume volume = volume_of({13, 11, 9}, [&](Vec3i) {
        return random.whole(0, 30) == 0 ? 1000 : random.whole(-1000, 290);
    });
    volume.grid.spacing_mm = {random.real(0.5, 2), random.real(0.5, 2), random.real(0.5, 2)};
    volume.grid.direction = random.rotation(random.whole(0, 1) == 1);
    return volume;
}

/// A smooth field of random waves.
std::function<Vec3d(Vec3d)> random_field(Random& random, double longest_mm) {
    struct Wave {
        Vec3d along, amplitude;
        double phase;
    };
    std::vector<Wave> waves;
    for (int n = 0; n < 3; ++n)
        waves.push_back({random.vector(0.3), random.vector(longest_mm), random.real(0, 6)});
    return [=](Vec3d x) {
        Vec3d u{0, 0, 0};
        for (const Wave& w : waves) u = u + std::sin(dot(w.along, x) + w.phase) * w.amplitude;
        return u;
    };
}

ChainMailSettings plain(double offset) {
    ChainMailSettings settings;
    settings.offset = offset;
    settings.air_enabled = false;
    settings.smallest_bone_mm3 = 0;
    settings.max_movement_mm = 300;
    return settings;
}

TEST(Follow, TheLatticeIsValidAndBoneAtRest) {
    Random random(seed_of_follow());
    for (int n = 0; n < 20; ++n) {
        const TaskArena arena(1 + n % 2);
        const Volume volume = random_scan(random);
        ChainMailSettings settings = plain(random.real(0.05, 0.3));
        settings.brick_size = n % 3 ? 8 : 3;
        settings.air_enabled = n % 4 == 3;
        settings.limits = n % 5 == 4 ? LinkLimits::Rounded : LinkLimits::Box;
        settings.factor = {1, random.real(0.3, 1), 1};
        ChainMail tissue = tissue_of(volume, arena, settings);
        const Box3i box = n % 2 ? voxel_box(volume.grid) : Box3i{{-4, -3, 0}, {10, 14, 9}};
        const auto report = tissue.follow(box, random_field(random, random.ratio(0.01, 30)));
        ASSERT_TRUE(report.ok()) << report.error().message;
        EXPECT_GT(report->fraction, 0);
        EXPECT_LE(report->fraction, 1);
        const LatticeState state = tissue.state();
        EXPECT_EQ(state.moved_elements, report->moved_elements);
        EXPECT_GT(state.moved_elements, 5);
        EXPECT_LE(state.max_violation_mm, 1e-9);
        for_each_element(volume.grid, [&](Vec3i e) {
            if (volume.at(e) > 300) {
                EXPECT_EQ(norm(tissue.displacement_mm(e)), 0);
            }
        });
        // It can be pushed afterwards, and undone.
        const auto push = tissue.push(
            {.point_mm = world_from_voxel(volume.grid, {6, 5, 4}), .push_mm = random.vector(1)});
        ASSERT_TRUE(push.ok());
        EXPECT_LE(tissue.state().max_violation_mm, 1e-9);
        while (tissue.undo_steps() > 0) ASSERT_TRUE(tissue.undo().ok());
        EXPECT_EQ(tissue.hash(), tissue_of(volume, arena, settings).hash());
    }
}

TEST(Follow, AFieldWithinTheLimitsIsFollowedExactlyAwayFromBone) {
    const TaskArena arena(1);
    const Volume volume = block({40, 40, 40});
    ChainMail tissue = tissue_of(volume, arena, plain(0.25));
    const auto ramp = [](Vec3d x) { return Vec3d{0.05 * (x.y - 20), -0.1 * (x.z - 20), 1}; };
    const auto report = tissue.follow(voxel_box(volume.grid), ramp);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->fraction, 1);
    EXPECT_GT(report->held_elements, 0);
    for (const Vec3i e : {Vec3i{20, 20, 20}, Vec3i{15, 22, 25}, Vec3i{12, 12, 12}}) {
        const Vec3d u = tissue.displacement_mm(e);
        EXPECT_LT(norm(u - ramp({double(e.x), double(e.y), double(e.z)})), 1e-5);
    }
    EXPECT_EQ(norm(tissue.displacement_mm({-1, 20, 20})), 0);
}

TEST(Follow, BesideBoneTissueMovesAsFarAsTheCityBlockDistanceAllows) {
    Random random(seed_of_follow());
    const TaskArena arena(1);
    Volume volume = block({17, 15, 13}, 40, {1, 1.5, 0.8});
    const Vec3i bone{random.whole(0, 16), random.whole(0, 14), random.whole(0, 12)};
    (*std::get_if<0>(&volume.voxels))[voxel_index(volume.grid, bone)] = 2000;
    ChainMail tissue = tissue_of(volume, arena, plain(0.2));
    ASSERT_TRUE(tissue.follow(voxel_box(volume.grid), [](Vec3d) { return Vec3d{9, -9, 9}; }).ok());
    const double w = 1040 / 4095.0, limit = 0.2 * (1 - w * w);
    const Vec3d cost = limit * volume.grid.spacing_mm;
    const double first = 0.5 * std::max({cost.x, cost.y, cost.z});
    for_each_element(volume.grid, [&](Vec3i e) {
        double room = 9;
        double to_bone = 0;
        for (int a = 0; a < 3; ++a) {
            const int border = 1 + std::min(e[a], volume.grid.size[a] - 1 - e[a]);
            room = std::min(room, border * cost[a] - first);
            to_bone += std::abs(e[a] - bone[a]) * cost[a];
        }
        room = std::max(0.0, std::min(room, to_bone - first));
        const Vec3d u = tissue.displacement_mm(e);
        EXPECT_LT(norm(u - room * Vec3d{1, -1, 1}), 1e-4);
    });
}

TEST(Follow, ItStopsAtTheMovementLimit) {
    const TaskArena arena(1);
    const Volume volume = block({30, 30, 30});
    ChainMailSettings settings = plain(0.3);
    settings.max_movement_mm = 1;
    ChainMail tissue = tissue_of(volume, arena, settings);
    const auto report = tissue.follow(voxel_box(volume.grid), [](Vec3d) { return Vec3d{0, 4, 0}; });
    ASSERT_TRUE(report.ok());
    EXPECT_LT(report->fraction, 0.25);
    EXPECT_GT(report->fraction, 0.2);
    EXPECT_LE(tissue.state().max_movement_mm, 1);
}

TEST(Follow, WhatItCannotFollowIsRefusedAndChangesNothing) {
    const TaskArena arena(1);
    const Volume volume = block({12, 12, 12});
    ChainMail tissue = tissue_of(volume, arena, plain(0.25));
    const auto still = [](Vec3d) { return Vec3d{1, 0, 0}; };
    const std::uint64_t before = tissue.hash();
    EXPECT_FALSE(tissue.follow({}, still).ok());
    EXPECT_FALSE(tissue.follow(voxel_box(volume.grid),
                               [](Vec3d) {
                                   return Vec3d{NAN, 0, 0};
                               })
                     .ok());
    EXPECT_FALSE(tissue.follow(voxel_box(volume.grid),
                               [](Vec3d) {
                                   return Vec3d{501, 0, 0};
                               })
                     .ok());
    EXPECT_EQ(tissue.hash(), before);
    EXPECT_EQ(tissue.undo_steps(), 0);
    ASSERT_TRUE(tissue.follow(voxel_box(volume.grid), still).ok());
    const std::uint64_t after = tissue.hash();
    EXPECT_NE(after, before);
    EXPECT_FALSE(tissue.follow(voxel_box(volume.grid), still).ok());
    EXPECT_EQ(tissue.hash(), after);
    ChainMailSettings bounded = plain(0.25);
    bounded.bounded = true;
    EXPECT_FALSE(tissue_of(volume, arena, bounded).follow(voxel_box(volume.grid), still).ok());
}

TEST(Follow, EachElementsMovementLimitCounts) {
    const TaskArena arena(1);
    for (const Vec3i tight : {Vec3i{0, 0, 0}, Vec3i{11, 11, 11}, Vec3i{5, 6, 7}}) {
        Volume volume = block({12, 12, 12});
        (*std::get_if<0>(&volume.voxels))[voxel_index(volume.grid, tight)] = 50;
        ChainMailSettings settings = plain(0.3);
        settings.custom_law = [](int value) {
            return ElementLimits{
                {.3, .3, .3}, {.3, .3, .3}, {.3, .3, .3}, value == 50 ? 1.0 : 100.0, false};
        };
        ChainMail tissue = tissue_of(volume, arena, settings);
        const auto report = tissue.follow(voxel_box(volume.grid), [](Vec3d) {
            return Vec3d{0, 4, 0};
        });
        ASSERT_TRUE(report.ok());
        EXPECT_NEAR(report->fraction, 0.25, 1e-5);
    }
}

}  // namespace
}  // namespace pliant::test
