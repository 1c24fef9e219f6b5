// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/changed_blocks.h"

#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

#include "protocol/dirty_blocks.h"
#include "support/random.h"
#include "volume/boxes.h"

namespace pliant::serve {
namespace {

using test::Random;

Volume random_volume(Vec3i size, bool is_16_bit, Random& random) {
    Volume volume;
    volume.grid.size = size;
    if (is_16_bit) {
        VoxelArray<std::int16_t> voxels(dense_count(size));
        for (auto& value : voxels) value = std::int16_t(random.whole(-1000, 1000));
        volume.voxels = std::move(voxels);
    } else {
        VoxelArray<float> voxels(dense_count(size));
        for (auto& value : voxels) value = float(random.real(-1000, 1000));
        volume.voxels = std::move(voxels);
    }
    return volume;
}

void change(Volume& volume, Vec3i at) {
    std::visit([&](auto& voxels) { voxels.data()[dense_index(at, volume.grid.size)] += 1; },
               volume.voxels);
}

Vec3i random_voxel(Vec3i size, Random& random) {
    return {random.whole(0, size.x - 1), random.whole(0, size.y - 1), random.whole(0, size.z - 1)};
}

TEST(ChangedBlocks, AreThoseWithAChangedVoxel) {
    const std::uint64_t seed = 12;
    Random random(seed);
    const TaskArena arena(2);
    for (int round = 0; round < 60; ++round) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", round " + std::to_string(round));
        const Vec3i size{random.whole(1, 50), random.whole(1, 50), random.whole(1, 50)};
        Volume volume = random_volume(size, round % 2 == 0, random);
        const std::vector<Box3i> all{voxel_box(volume.grid)};
        ChangedBlocks blocks;
        DirtyBlocks first(size);
        for (const Box3i& box : blocks.find(volume, all, arena)) first.mark(box);
        for_each_in(all[0], [&](Vec3i p) { EXPECT_TRUE(first.contains(p)); });
        EXPECT_TRUE(blocks.find(volume, all, arena).empty());
        // A few voxels, and boxes that overlap.
        DirtyBlocks expected(size);
        std::vector<Box3i> boxes;
        for (int n = random.whole(0, 8); n > 0; --n) {
            const Vec3i at = random_voxel(size, random), other = random_voxel(size, random);
            change(volume, at);
            expected.mark({at, at + Vec3i{1, 1, 1}});
            boxes.push_back(hull({at, at + Vec3i{1, 1, 1}}, {other, other + Vec3i{1, 1, 1}}));
        }
        DirtyBlocks found(size);
        std::int64_t voxels = 0;
        for (const Box3i& box : blocks.find(volume, boxes, arena)) {
            found.mark(box);
            voxels += box_count(box);
        }
        EXPECT_EQ(found.blocks(), expected.blocks());
        EXPECT_LE(voxels, std::int64_t(64 * expected.blocks().size()));
        EXPECT_TRUE(blocks.find(volume, boxes, arena).empty());
    }
}

TEST(ChangedBlocks, AllCountAfterForgetting) {
    Random random(13);
    const TaskArena arena(1);
    const Volume volume = random_volume({9, 9, 9}, true, random);
    const std::vector<Box3i> box{{{0, 0, 0}, {5, 4, 4}}};
    ChangedBlocks blocks;
    EXPECT_EQ(blocks.find(volume, box, arena).size(), 1U);  // two, joined
    EXPECT_TRUE(blocks.find(volume, box, arena).empty());
    blocks.forget();
    EXPECT_EQ(blocks.find(volume, box, arena).size(), 1U);
    EXPECT_TRUE(blocks.find(volume, {}, arena).empty());
}

}  // namespace
}  // namespace pliant::serve
