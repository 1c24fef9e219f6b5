// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Incremental updates against a complete write.
// Covers: resample/scatter.cpp, resample/snapshot.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <utility>
#include <variant>
#include <vector>

#include "resample/lattices.h"
#include "resample/scatter.h"
#include "support/count_allocations.h"
#include "support/random.h"

namespace pliant::test {
namespace {

Volume noise(Random& random, Vec3i size, Vec3d spacing_mm) {
    return make_volume(size, spacing_mm,
                       [&](Vec3d) { return std::int16_t(random.whole(-900, 900)); });
}

/// Number of differing voxels outside of some boxes.
int count_changes(const Volume& before, const Volume& after, std::span<const Box3i> outside) {
    int changes = 0;
    const Vec3i n = before.grid.size;
    for (int z = 0; z < n.z; ++z)
        for (int y = 0; y < n.y; ++y)
            for (int x = 0; x < n.x; ++x) {
                const Vec3i p{x, y, z};
                if (before.at(p) == after.at(p)) continue;
                changes += std::none_of(outside.begin(), outside.end(),
                                        [&](const Box3i& box) { return contains(box, p); });
            }
    return changes;
}

TEST(LiveDeformation, RandomPushesGiveTheBitsOfTheOneShotForm) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(1 + int(seed % 3));
        const Volume volume =
            noise(random, {random.whole(30, 60), random.whole(30, 50), random.whole(20, 45)},
                  {1, random.real(0.6, 1.4), random.real(0.8, 2)});
        ChainMailSettings settings;
        settings.brick_size = seed % 3 == 0 ? 5 : 8;
        settings.bone_threshold_hu = 2000;
        ChainMail tissue = std::move(ChainMail::create(volume, settings, arena)).value();
        LiveDeformation live = LiveDeformation::create(tissue).value();
        Volume before = live.volume();
        for (int push = 0; push < 12; ++push) {
            const Vec3d ijk{random.real(0, volume.grid.size.x - 1),
                            random.real(0, volume.grid.size.y - 1),
                            random.real(0, volume.grid.size.z - 1)};
            ASSERT_TRUE(tissue
                            .push({.point_mm = world_from_voxel(volume.grid, ijk),
                                   .push_mm = random.vector(random.ratio(0.2, 12)),
                                   .sphere_radius_mm = push % 2 ? 3.0 : 0.0})
                            .ok());
            const LiveUpdate update = live.update().value();
            const Deformed once = deform_volume(tissue).value();
            ASSERT_EQ(live.volume().voxels, once.volume.voxels) << "push " << push;
            ASSERT_EQ(count_changes(before, live.volume(), update.boxes), 0);
            EXPECT_LE(update.written_voxels, once.written_voxels);
            before = live.volume();
        }
    }
}

TEST(LiveDeformation, TheBoxesAfterANewStartHoldWhatIsRestored) {
    Random random(9);
    const TaskArena arena(1);
    const Volume volume = noise(random, {36, 30, 28}, {1, 1, 1});
    const auto make = [&] {
        return std::move(ChainMail::create(volume, {.bone_threshold_hu = 2000}, arena)).value();
    };
    ChainMail first = make(), second = make();
    LiveDeformation live = LiveDeformation::create(first).value();
    // In the first brick, in the last one, and between them.
    for (const Vec3d place : {Vec3d{3, 3, 3}, Vec3d{33, 27, 26}, Vec3d{17, 14, 13}}) {
        ASSERT_TRUE(
            first.push({.point_mm = place, .push_mm = {2, 1, 1}, .sphere_radius_mm = 2}).ok());
        ASSERT_TRUE(live.update().ok());
    }
    const Volume before = live.volume();
    ASSERT_NE(before.at({3, 3, 3}), volume.at({3, 3, 3}));
    live.start_over(second);
    EXPECT_EQ(live.volume().voxels, volume.voxels);
    const LiveUpdate update = live.update().value();
    EXPECT_EQ(live.volume().voxels, volume.voxels);
    EXPECT_EQ(count_changes(before, live.volume(), update.boxes), 0);
    EXPECT_TRUE(live.update().value().boxes.empty());
}

TEST(LiveDeformation, WritesToABufferOfTheHost) {
    Random random(3);
    const TaskArena arena(2);
    const Volume volume = noise(random, {40, 36, 30}, {1, 1, 1.2});
    const auto& voxels = std::get<VoxelArray<std::int16_t>>(volume.voxels);
    ChainMail tissue =
        std::move(ChainMail::create(volume, {.bone_threshold_hu = 2000}, arena)).value();
    std::vector<std::int16_t> buffer(voxels.size(), 7);
    Volume target;
    target.grid = volume.grid;
    target.voxels = VoxelArray<std::int16_t>::viewed(std::span(buffer));
    const auto wrong = [&](auto change) {
        Volume other;
        other.grid = volume.grid;
        other.voxels = VoxelArray<std::int16_t>(voxels.size());
        change(other);
        const auto refused = LiveDeformation::create(tissue, std::move(other));
        return !refused.ok() && refused.error().code == ErrorCode::InvalidArgument;
    };
    EXPECT_TRUE(wrong([](Volume& v) { v.voxels = VoxelArray<float>(voxel_count(v.grid)); }));
    EXPECT_TRUE(wrong([](Volume& v) { std::swap(v.grid.size.x, v.grid.size.y); }));
    EXPECT_TRUE(wrong([](Volume& v) { v.voxels = VoxelArray<std::int16_t>(5); }));
    LiveDeformation live = LiveDeformation::create(tissue, std::move(target)).value();
    EXPECT_TRUE(std::equal(buffer.begin(), buffer.end(), voxels.begin()));
    for (int push = 0; push < 3; ++push) {
        const Vec3d place = world_from_voxel(volume.grid, {12.0 + 4 * push, 18, 15});
        ASSERT_TRUE(
            tissue.push({.point_mm = place, .push_mm = random.vector(4), .sphere_radius_mm = 3})
                .ok());
        ASSERT_TRUE(live.update().ok());
        const Deformed once = deform_volume(tissue).value();
        const auto& expected = std::get<VoxelArray<std::int16_t>>(once.volume.voxels);
        ASSERT_TRUE(std::equal(buffer.begin(), buffer.end(), expected.begin()));
        ASSERT_FALSE(std::equal(buffer.begin(), buffer.end(), voxels.begin()));
    }
}

TEST(LiveDeformation, AnUpdateWithoutAChangeWritesNothing) {
    const TaskArena arena(2);
    Random random(2);
    const Volume volume = noise(random, {30, 30, 30}, {1, 1, 1});
    ChainMailSettings settings;
    settings.bone_threshold_hu = 2000;
    ChainMail tissue = std::move(ChainMail::create(volume, settings, arena)).value();
    LiveDeformation live = LiveDeformation::create(tissue).value();
    EXPECT_TRUE(live.update().value().boxes.empty());
    ASSERT_TRUE(tissue.push({.point_mm = {15, 15, 15}, .push_mm = {2, 0, 1}}).ok());
    EXPECT_GT(live.update().value().written_voxels, 0);
    const LiveUpdate second = live.update().value();
    EXPECT_TRUE(second.boxes.empty());
    EXPECT_TRUE(is_empty(second.dirty_box));
    EXPECT_EQ(second.written_voxels, 0);
}

TEST(LiveDeformation, ASmallChangeFarFromALargeOneWritesOnlyItsOwnBricks) {
    const TaskArena arena(1);
    Random random(3);
    const Volume volume = noise(random, {96, 32, 32}, {1, 1, 1});
    Volume deformed = volume;
    Lattice lattice = displaced_lattice(volume, {{8, 8, 8}, {24, 24, 24}}, [](Vec3d) {
        return Vec3d{0.5, 0.25, 0};
    });
    Scatter scatter(volume, arena);
    EXPECT_GT(scatter.look(lattice, Mapping::Cells, deformed).count, 1000);
    scatter.write(lattice, Mapping::Cells, deformed, nullptr, {});
    displace(lattice, {{80, 12, 12}, {84, 16, 16}}, [](Vec3d) { return Vec3d{0.2, 0, 0}; });
    const OpenVoxels second = scatter.look(lattice, Mapping::Cells, deformed);
    EXPECT_LT(second.count, 200);
    EXPECT_GE(second.box.begin.x, 72);
    scatter.write(lattice, Mapping::Cells, deformed, nullptr, {});
    for (const Box3i& box : scatter.written_boxes()) EXPECT_GE(box.begin.x, 64);
    const Deformed once = deform_by_field(volume, lattice, Mapping::Cells, false, arena);
    EXPECT_EQ(deformed.voxels, once.volume.voxels);
}

TEST(LiveDeformation, WhatIsAtRestAgainIsTheScanAgain) {
    const TaskArena arena(2);
    Random random(4);
    const Volume volume = noise(random, {40, 40, 40}, {1, 1, 1});
    const Box3i box{{10, 10, 10}, {30, 30, 30}};
    Lattice lattice = displaced_lattice(volume, box, [](Vec3d p) {
        return Vec3d{3 + 0.1 * p.x, -0.1 * p.y, 0.05 * p.z};
    });
    Volume deformed = volume;
    Scatter scatter(volume, arena);
    scatter.look(lattice, Mapping::Cells, deformed);
    scatter.write(lattice, Mapping::Cells, deformed, nullptr, {});
    EXPECT_NE(deformed.voxels, volume.voxels);
    displace(lattice, box, [](Vec3d) { return Vec3d{0, 0, 0}; });
    ASSERT_EQ(lattice.resident_brick_count(), 0);
    EXPECT_EQ(scatter.look(lattice, Mapping::Cells, deformed).count, 0);
    scatter.write(lattice, Mapping::Cells, deformed, nullptr, {});
    EXPECT_FALSE(scatter.written_boxes().empty());
    EXPECT_EQ(deformed.voxels, volume.voxels);
}

TEST(LiveDeformation, WhatADeformationLeavesIsTheScanAgainVoxelByVoxel) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume volume = noise(random, {42, 40, 37}, {1, 1, 1});
        const Box3i box{{8, 8, 8}, {32, 32, 32}};
        // Faces move by a voxel or two, to the first voxel of a brick and away from it.
        const auto field = [&] {
            Box3i inner = box;
            for (int a = 0; a < 3; ++a) {
                inner.begin[a] += int(random.whole(0, 9));
                inner.end[a] -= int(random.whole(0, 9));
            }
            const Vec3d u = random.vector(0.4);
            return [inner, u](Vec3d p) {
                const Vec3i e{int(p.x), int(p.y), int(p.z)};
                return contains(inner, e) ? u : Vec3d{0, 0, 0};
            };
        };
        Lattice lattice = displaced_lattice(volume, box, field());
        Volume deformed = volume;
        Scatter scatter(volume, arena);
        for (int turn = 0; turn < 25; ++turn) {
            scatter.look(lattice, Mapping::Cells, deformed);
            scatter.write(lattice, Mapping::Cells, deformed, nullptr, {});
            const Deformed once = deform_by_field(volume, lattice, Mapping::Cells, false, arena);
            ASSERT_EQ(deformed.voxels, once.volume.voxels) << "turn " << turn;
            displace(lattice, box, field());
        }
    }
}

TEST(LiveDeformation, AnUpdateAllocatesNothingOnceItHasSeenTheLargestDeformation) {
    const TaskArena arena(1);
    Random random(5);
    const Volume volume = noise(random, {48, 48, 48}, {1, 1, 1});
    ChainMailSettings settings;
    settings.bone_threshold_hu = 2000;
    ChainMail tissue = std::move(ChainMail::create(volume, settings, arena)).value();
    LiveDeformation live = LiveDeformation::create(tissue).value();
    const auto drag = [&](Vec3d push_mm) {
        ASSERT_TRUE(tissue.push({.point_mm = {24, 24, 24}, .push_mm = push_mm}).ok());
    };
    std::int64_t counted = 0;
    std::int64_t written = 0;
    for (int step = 0; step < 10; ++step) {
        const double x = step % 2 ? 3 : -3;
        drag({x, 0.5 * x, 0});
        const std::int64_t before = allocation_count();
        const LiveUpdate update = live.update().value();
        if (step < 5) continue;
        counted += allocation_count() - before;
        written += update.written_voxels;
    }
    EXPECT_GT(written, 4000);
    EXPECT_EQ(counted, 0);
}

}  // namespace
}  // namespace pliant::test
