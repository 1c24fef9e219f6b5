// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Real scans, where they are at hand.
// Covers: formats/read_volume.cpp.

#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

namespace fs = std::filesystem;

const fs::path kData = PLIANT_SHARED_DATA;

#define PLIANT_NEEDS_SHARED_DATA() \
    if (!fs::is_directory(kData)) GTEST_SKIP() << kData << " is missing"

struct Scan {
    const char* name;
    Vec3i size;
    Vec3d spacing_mm;
    int handedness;
    float min_hu, max_hu;
};

const Scan kScans[] = {
    {"thorax_ct_256.nrrd", {256, 256, 137}, {1.5625, 1.5625, 2}, 1, -1000, 1851},
    {"thorax_ct_airways_crop.nrrd", {224, 192, 201}, {0.78125, 0.78125, 1}, 1, -1000, 1870},
    {"thorax_ct_airways_crop-label.nrrd", {224, 192, 201}, {0.78125, 0.78125, 1}, 1, 0, 1},
    {"abdomen_ct_3mm.nii.gz", {122, 101, 112}, {3, 3, 3}, 1, -1207, 3382},
    {"abdomen_ct_3mm-label.nii.gz", {122, 101, 112}, {3, 3, 3}, 1, 0, 117},
    {"aorta_cta_1p5mm.nii.gz", {120, 126, 164}, {1.5, 1.5, 1.5}, 1, -1078, 3343},
    {"aorta_cta_1p5mm-label.nii.gz", {120, 126, 164}, {1.5, 1.5, 1.5}, 1, 0, 2},
    {"head_ct_tiny_64.nrrd", {64, 64, 93}, {3.2, 3.2, 1.5}, 1, -1024, 2902},
};

TEST(SharedScans, AreReadAsTheyAreDescribed) {
    PLIANT_NEEDS_SHARED_DATA();
    for (const Scan& scan : kScans) {
        const auto volume = read_volume(kData / scan.name);
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        EXPECT_EQ(volume->grid.size, scan.size) << scan.name;
        EXPECT_LT(norm(volume->grid.spacing_mm - scan.spacing_mm), 1e-6) << scan.name;
        EXPECT_NEAR(determinant(volume->grid.direction), scan.handedness, 1e-6) << scan.name;
        ASSERT_TRUE(volume->is_16_bit()) << scan.name;
        const auto& voxels = std::get<0>(volume->voxels);
        const auto [min, max] = std::minmax_element(voxels.begin(), voxels.end());
        EXPECT_EQ(*min, scan.min_hu) << scan.name;
        EXPECT_EQ(*max, scan.max_hu) << scan.name;
    }
}

TEST(SharedScans, TheDicomFolderShowsTheSameBodyAsTheCrop) {
    PLIANT_NEEDS_SHARED_DATA();
    const auto slices = read_volume(kData / "dicom_thorax_10");
    ASSERT_TRUE(slices.ok()) << slices.error().message;
    EXPECT_EQ(slices->grid.size, (Vec3i{512, 512, 10}));
    EXPECT_LT(norm(slices->grid.spacing_mm - Vec3d{0.78125, 0.78125, 1}), 1e-6);
    const auto crop = read_volume(kData / "thorax_ct_airways_crop.nrrd");
    ASSERT_TRUE(crop.ok()) << crop.error().message;
    std::size_t compared = 0;
    for (int k = 0; k < 10; ++k)
        for (int j = 0; j < 512; j += 3)
            for (int i = 0; i < 512; i += 3) {
                const Vec3d x = world_from_voxel(slices->grid, {double(i), double(j), double(k)});
                const Vec3d v = voxel_from_world(crop->grid, x);
                const Vec3i nearest{int(std::lround(v.x)), int(std::lround(v.y)),
                                    int(std::lround(v.z))};
                if (!contains(voxel_box(crop->grid), nearest)) continue;
                ASSERT_LT(std::abs(v.z - nearest.z), 1e-3);
                // The crop's values were clipped to -1000 … 3095 HU.
                ASSERT_EQ(std::max(-1000.f, slices->at({i, j, k})), crop->at(nearest));
                ++compared;
            }
    EXPECT_GT(compared, 10000u);
}

TEST(SharedScans, SurviveWritingAndReading) {
    PLIANT_NEEDS_SHARED_DATA();
    const test::TemporaryFolder folder;
    for (const char* name : {"head_ct_tiny_64.nrrd", "abdomen_ct_3mm.nii.gz", "dicom_thorax_10"}) {
        const auto volume = read_volume(kData / name);
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        ASSERT_TRUE(write_volume(folder.path() / "a.nrrd", *volume).ok());
        const auto again = read_volume(folder.path() / "a.nrrd");
        ASSERT_TRUE(again.ok()) << again.error().message;
        EXPECT_EQ(again->voxels, volume->voxels);
        EXPECT_EQ(again->grid.origin_mm, volume->grid.origin_mm);
        EXPECT_LT(norm(again->grid.spacing_mm - volume->grid.spacing_mm), 1e-12);
    }
}

TEST(SharedScans, MeshesAreNoScans) {
    PLIANT_NEEDS_SHARED_DATA();
    for (const char* name : {"aorta_surface_segment1_vmtk.vtp", "thorax_airway_path_left.mrk.json",
                             "README.md", "liver_set"})
        EXPECT_FALSE(read_volume(kData / name).ok()) << name;
}

}  // namespace
}  // namespace pliant
