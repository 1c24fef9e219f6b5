// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: volume/volume.cpp.

#include <gtest/gtest.h>
#include <pliant/volume.h>

#include "support/random.h"

namespace pliant {
namespace {

TEST(Slices, OneSliceBecomesTwoBesideItAndOneAgain) {
    test::Random random(2);
    for (const Vec3i size : {Vec3i{5, 4, 1}, {1, 4, 3}, {5, 1, 1}, {1, 1, 1}}) {
        Volume volume;
        volume.grid.size = size;
        volume.grid.spacing_mm = {0.5, 2, 3};
        volume.grid.origin_mm = random.vector(100);
        volume.grid.direction = random.rotation(true);
        volume.key_values = {{"a", "b"}};
        for (float& v : volume.voxels.emplace<1>(voxel_count(volume.grid)))
            v = float(random.real(-1, 1));
        const auto doubled = with_doubled_slices(volume);
        ASSERT_TRUE(doubled.ok());
        EXPECT_TRUE(check_volume(*doubled).ok());
        EXPECT_EQ(doubled->key_values, volume.key_values);
        for (int a = 0; a < 3; ++a) EXPECT_EQ(doubled->grid.size[a], std::max(2, size[a]));
        // The middle between the two has the original value.
        for (int k = 0; k < size.z; ++k)
            for (int j = 0; j < size.y; ++j)
                for (int i = 0; i < size.x; ++i) {
                    const Vec3d x = world_from_voxel(volume.grid, {1.0 * i, 1.0 * j, 1.0 * k});
                    EXPECT_NEAR(sample_linear(*doubled, voxel_from_world(doubled->grid, x)),
                                volume.at({i, j, k}), 1e-6);
                }
        const auto single = with_single_slices(*doubled, volume.grid);
        ASSERT_TRUE(single.ok());
        EXPECT_EQ(single->grid, volume.grid);
        EXPECT_EQ(single->voxels, volume.voxels);
    }
}

TEST(Slices, OtherVolumesStayAsTheyAre) {
    Volume volume;
    volume.grid.size = {2, 3, 2};
    volume.grid.origin_mm = {1, 2, 3};
    volume.voxels = VoxelArray<std::int16_t>(std::vector<std::int16_t>(12, 5));
    const auto same = with_doubled_slices(volume);
    ASSERT_TRUE(same.ok());
    EXPECT_EQ(same->grid, volume.grid);
    EXPECT_EQ(same->voxels, volume.voxels);
}

}  // namespace
}  // namespace pliant
