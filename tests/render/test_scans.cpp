// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Real scans, where they are.
// Covers: render/ray_caster.cpp.

#include <gtest/gtest.h>
#include <pliant/render.h>
#include <pliant/scan_files.h>

#include <cmath>
#include <filesystem>

namespace pliant {
namespace {

/// Voxels of a label map's label 1 near a world point.
int label_count_near(const Volume& label, Vec3d x_mm) {
    const Vec3d p = voxel_from_world(label.grid, x_mm);
    int count = 0;
    for (int k = 0; k < 27; ++k) {
        const Vec3i q{int(std::lround(p.x)) + k % 3 - 1, int(std::lround(p.y)) + k / 3 % 3 - 1,
                      int(std::lround(p.z)) + k / 9 - 1};
        if (contains(voxel_box(label.grid), q) && label.at(q) == 1) ++count;
    }
    return count;
}

/// A chest, and a published segmentation of its airways.
class Scans : public ::testing::Test {
  protected:
    void SetUp() override {
        const std::filesystem::path folder = PLIANT_SHARED_DATA;
        if (!std::filesystem::exists(folder / "thorax_ct_airways_crop.nrrd"))
            GTEST_SKIP() << "needs " << folder / "thorax_ct_airways_crop.nrrd";
        auto read = read_volume(folder / "thorax_ct_airways_crop.nrrd");
        auto read_label = read_volume(folder / "thorax_ct_airways_crop-label.nrrd");
        ASSERT_TRUE(read && read_label);
        scan = std::move(*read);
        label = std::move(*read_label);
    }
    TaskArena arena{2};
    Volume scan, label;
};

TEST_F(Scans, TheChestsFirstViewIsInTheAirways) {
    const auto view = find_endoscope(scan, -500, Polarity::Rising, arena);
    ASSERT_TRUE(view);
    EXPECT_EQ(label_count_near(label, view->eye_mm), 27);

    // The wall that it sees is where the segmentation of the lumen ends.
    const auto hit =
        RayCaster(scan, arena).first_hit(view->eye_mm, view->look, -500, Polarity::Rising);
    ASSERT_TRUE(hit);
    EXPECT_GT(hit->distance_mm, 25);
    EXPECT_GT(label_count_near(label, hit->point_mm + 3.0 * hit->normal), 0);
}

TEST_F(Scans, TheCarinaIsSeenFromTheAirways) {
    const Vec3d carina{-22, 174, -495};
    const Endoscope e = aim_endoscope(scan, carina, {6, 0, 0}, -500, Polarity::Rising, arena);
    EXPECT_GT(label_count_near(label, e.eye_mm), 20);
    const auto hit = RayCaster(scan, arena).first_hit(e.eye_mm, e.look, -500, Polarity::Rising);
    ASSERT_TRUE(hit);
    EXPECT_LT(norm(hit->point_mm - carina), 4);
}

}  // namespace
}  // namespace pliant
