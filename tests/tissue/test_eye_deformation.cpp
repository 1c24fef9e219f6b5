// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One call per frame of an endoscopy: the eye is never in tissue, and the boxes hold all changes.

#include <gtest/gtest.h>
#include <pliant/models/eye_deformation.h>
#include <pliant/resample.h>

#include <cmath>
#include <limits>

#include "support/each_allocation.h"
#include "support/random.h"

namespace pliant::test {
namespace {

/// A tube of 7 mm along z through tissue, with bone on one side.
Volume tube() {
    Volume volume;
    volume.grid = {.size = {40, 40, 32}, .spacing_mm = {0.9, 0.9, 1.3}, .origin_mm = {5, -3, 40}};
    std::vector<std::int16_t> voxels;
    for (int z = 0; z < 32; ++z)
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40; ++x) {
                const double r = 0.9 * std::hypot(x - 19.5, y - 19.5);
                voxels.push_back(std::int16_t(r < 7 ? -1000 : x < 8 ? 1200 : 40));
            }
    volume.voxels = voxels;
    return volume;
}

TEST(EyeDeformation, TheEyeIsNeverInTissueAndTheBoxesHoldAllChanges) {
    const Volume scan = tube();
    const TaskArena arena(2);
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        auto made = EyeDeformation::create(scan, {.radius_mm = 1.5}, arena);
        ASSERT_TRUE(made.ok()) << made.error().message;
        EyeDeformation& endoscopy = **made;
        Volume shown = scan;
        Vec3d eye = world_from_voxel(scan.grid, {19.5, 19.5, 15});
        int touched = 0, stopped = 0;
        for (int frame = 0; frame < 40; ++frame) {
            const Vec3d wanted = eye + random.vector(4);
            const auto moved = endoscopy.deform(eye, wanted);
            if (!moved.ok()) {  // out of the scan
                EXPECT_EQ(moved.error().code, ErrorCode::InvalidArgument);
                continue;
            }
            eye = moved->eye_mm;
            touched += moved->touched;
            stopped += moved->is_stopped;
            if (!moved->touched && !moved->is_stopped) {
                EXPECT_LE(norm(eye - wanted), 1e-9);
            }
            EXPECT_LT(sample_linear(endoscopy.volume(), voxel_from_world(scan.grid, eye)), -500);
            auto& voxels = std::get<VoxelArray<std::int16_t>>(shown.voxels);
            for (const Box3i& box : moved->boxes)
                for (int z = box.begin.z; z < box.end.z; ++z)
                    for (int y = box.begin.y; y < box.end.y; ++y)
                        for (int x = box.begin.x; x < box.end.x; ++x)
                            voxels[voxel_index(scan.grid, {x, y, z})] =
                                std::int16_t(endoscopy.volume().at({x, y, z}));
            ASSERT_EQ(shown.voxels, deform_volume(endoscopy.tissue())->volume.voxels);
        }
        EXPECT_GT(touched, 5);
        EXPECT_GT(stopped, 0);
    }
}

TEST(EyeDeformation, BadInputIsAnErrorAndChangesNothing) {
    const Volume scan = tube();
    const TaskArena arena(1);
    EXPECT_EQ(EyeDeformation::create(scan, {.radius_mm = 0}, arena).error().message,
              "radius_mm: expected a radius above 0, found 0");
    auto endoscopy = EyeDeformation::create(scan, {}, arena).value();
    const Vec3d eye = world_from_voxel(scan.grid, {19.5, 19.5, 15});
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Vec3d wrong : {Vec3d{nan, 0, 0}, Vec3d{1e9, 0, 0}, Vec3d{0, 0, 0} - eye}) {
        const auto moved = endoscopy->deform(eye, wrong);
        ASSERT_FALSE(moved.ok());
        EXPECT_EQ(moved.error().code, ErrorCode::InvalidArgument);
        EXPECT_EQ(moved.error().message.find('\n'), std::string::npos);
    }
    EXPECT_EQ(endoscopy->tissue().moved_box(), Box3i{});
    const auto still = endoscopy->deform(eye, eye);
    ASSERT_TRUE(still.ok());
    EXPECT_EQ(still->eye_mm, eye);
    EXPECT_TRUE(still->boxes.empty());
}

}  // namespace
}  // namespace pliant::test
