// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Frames of an endoscopy: the eye is never in tissue, and the boxes hold all changes.
// Covers: chainmail/slide.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <cmath>
#include <limits>

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

TEST(Endoscopy, TheEyeIsNeverInTissueAndTheBoxesHoldAllChanges) {
    const Volume scan = tube();
    const TaskArena arena(2);
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        ChainMail tissue = ChainMail::create(scan, {}, arena).value();
        LiveDeformation live = LiveDeformation::create(tissue).value();
        Volume shown = scan;
        Vec3d eye = world_from_voxel(scan.grid, {19.5, 19.5, 15});
        int touched = 0, stopped = 0;
        for (int frame = 0; frame < 40; ++frame) {
            const Vec3d wanted = eye + random.vector(4);
            const auto slid = slide_sphere(tissue, {eye, wanted - eye, 1.5}, TissueValues{});
            if (!slid.ok()) {  // out of the scan
                EXPECT_EQ(slid.error().code, ErrorCode::InvalidArgument);
                continue;
            }
            eye = slid->end_mm;
            const bool is_stopped = slid->limited_by != LimitedBy::None;
            touched += slid->contacts > 0;
            stopped += is_stopped;
            if (slid->contacts == 0 && !is_stopped) {
                EXPECT_LE(norm(eye - wanted), 1e-9);
            }
            const LiveUpdate update = live.update().value();
            EXPECT_LT(sample_linear(live.volume(), voxel_from_world(scan.grid, eye)), -500);
            auto& voxels = std::get<VoxelArray<std::int16_t>>(shown.voxels);
            for (const Box3i& box : update.boxes)
                for (int z = box.begin.z; z < box.end.z; ++z)
                    for (int y = box.begin.y; y < box.end.y; ++y)
                        for (int x = box.begin.x; x < box.end.x; ++x)
                            voxels[voxel_index(scan.grid, {x, y, z})] =
                                std::int16_t(live.volume().at({x, y, z}));
            ASSERT_EQ(shown.voxels, deform_volume(tissue)->volume.voxels);
        }
        EXPECT_GT(touched, 5);
        EXPECT_GT(stopped, 0);
    }
}

TEST(Endoscopy, BadInputIsAnErrorAndChangesNothing) {
    const Volume scan = tube();
    const TaskArena arena(1);
    ChainMail tissue = ChainMail::create(scan, {}, arena).value();
    LiveDeformation live = LiveDeformation::create(tissue).value();
    const Vec3d eye = world_from_voxel(scan.grid, {19.5, 19.5, 15});
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Vec3d wrong : {Vec3d{nan, 0, 0}, Vec3d{1e9, 0, 0}, Vec3d{0, 0, 0} - eye, eye}) {
        const auto slid = slide_sphere(tissue, {eye, wrong - eye, 2}, TissueValues{});
        ASSERT_FALSE(slid.ok());
        EXPECT_EQ(slid.error().code, ErrorCode::InvalidArgument);
        EXPECT_EQ(slid.error().message.find('\n'), std::string::npos);
    }
    EXPECT_EQ(tissue.moved_box(), Box3i{});
    EXPECT_TRUE(live.update().value().boxes.empty());
}

}  // namespace
}  // namespace pliant::test
