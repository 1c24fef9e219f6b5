// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One image of a 4-D file, wherever the file has its axis of time; and images of one slice.
// Covers: formats/image_header.cpp.

#include "support/damaged_scan.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

namespace pliant {
namespace {

using test::packed;

constexpr int kFrames = 5;

/// Value of voxel n of a frame.
int value_of(int frame, int n) {
    return 1000 * frame + n;
}

/// Numbers with time after `run` voxels.
std::vector<std::int16_t> numbers(int run) {
    std::vector<std::int16_t> all;
    for (int block = 0; block < 24 / run; ++block)
        for (int frame = 0; frame < kFrames; ++frame)
            for (int n = 0; n < run; ++n)
                all.push_back(std::int16_t(value_of(frame, block * run + n)));
    return all;
}

void expect_frames(const std::filesystem::path& path) {
    for (int frame = 0; frame < kFrames; ++frame) {
        ReadOptions options;
        options.frame = frame;
        const auto volume = read_volume(path, options);
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 2}));
        EXPECT_EQ(volume->grid.spacing_mm, (Vec3d{1, 1, 2}));
        EXPECT_EQ(volume->grid.direction, kIdentity3);
        for (int n = 0; n < 24; ++n)
            ASSERT_EQ(std::get<0>(volume->voxels)[std::size_t(n)], value_of(frame, n))
                << path << " frame " << frame;
    }
    const auto all = read_volume(path);
    ASSERT_FALSE(all.ok());
    EXPECT_EQ(all.error().message, path.string() + ": holds 5 images, choose one with --frame 0…4");
    for (const int frame : {-1, 5}) {
        ReadOptions options;
        options.frame = frame;
        const auto none = read_volume(path, options);
        ASSERT_FALSE(none.ok());
        EXPECT_EQ(none.error().message, "--frame: found " + std::to_string(frame) +
                                            ", expected 0…4 for " + path.string());
    }
}

test::NiftiFile nifti_4d() {
    test::NiftiFile file;
    file.dim = {4, 4, 3, 2, kFrames, 1, 1, 1};
    file.sform = {-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 2, 0};
    file.data = packed(numbers(24));
    return file;
}

TEST(Frames, OfNiftiAreRead) {
    const test::TemporaryFolder folder;
    const std::string bytes = nifti_4d().bytes();
    expect_frames(folder.write("a.nii", bytes));
    expect_frames(folder.write("a.nii.gz", test::gzipped(bytes)));
}

TEST(Frames, OfNrrdAreReadWhereverTheirAxisIs) {
    const test::TemporaryFolder folder;
    test::NrrdFile file;
    file.dimension = "4";
    const struct {
        int run;
        const char *sizes, *kinds, *directions;
    } orders[] = {
        {1, "5 4 3 2", "list domain domain domain", "none (1,0,0) (0,1,0) (0,0,2)"},
        {1, "5 4 3 2", "time domain domain domain", "none (1,0,0) (0,1,0) (0,0,2)"},
        {4, "4 5 3 2", "domain domain domain domain", "(1,0,0) none (0,1,0) (0,0,2)"},
        {12, "4 3 5 2", "domain domain time domain", "(1,0,0) (0,1,0) none (0,0,2)"},
        {24, "4 3 2 5", "domain domain domain list", "(1,0,0) (0,1,0) (0,0,2) none"},
        {24, "4 3 2 5", "domain domain domain domain", "(1,0,0) (0,1,0) (0,0,2) none"},
    };
    for (const auto& order : orders) {
        SCOPED_TRACE(order.kinds);
        file.sizes = order.sizes;
        file.kinds = order.kinds;
        file.directions = order.directions;
        file.encoding = "raw";
        file.data = packed(numbers(order.run));
        expect_frames(folder.write("a.nrrd", file.bytes()));
        file.encoding = "gzip";
        file.data = test::gzipped(file.data);
        expect_frames(folder.write("a.nrrd", file.bytes()));
    }
}

TEST(Frames, OfMetaImagesAreRead) {
    const test::TemporaryFolder folder;
    test::MetaFile file;
    file.dimension = "4";
    file.sizes = "4 3 2 5";
    file.spacing = "1 1 2 1";
    file.offset = "0 0 0 0";
    file.matrix = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
    file.data = packed(numbers(24));
    expect_frames(folder.write("a.mha", file.bytes()));
}

TEST(Frames, OfLargeFilesAreMappedOrReadInPieces) {
    const test::TemporaryFolder folder;
    constexpr int kSide = 96;
    constexpr std::size_t kCount = std::size_t(kSide) * kSide * kSide;
    for (const bool adjacent : {false, true}) {
        std::vector<std::int16_t> all(3 * kCount);
        for (std::size_t n = 0; n < kCount; ++n)
            for (std::size_t f = 0; f < 3; ++f)
                all[adjacent ? 3 * n + f : f * kCount + n] = std::int16_t(n % 9973 + 10000 * f);
        test::NrrdFile file;
        file.dimension = "4";
        file.sizes = adjacent ? "3 96 96 96" : "96 96 96 3";
        file.kinds = adjacent ? "list domain domain domain" : "domain domain domain list";
        file.directions =
            adjacent ? "none (1,0,0) (0,1,0) (0,0,2)" : "(1,0,0) (0,1,0) (0,0,2) none";
        file.data = packed(all);
        const auto path = folder.write("a.nrrd", file.bytes());
        for (const bool may_map : {true, false}) {
            ReadOptions options;
            options.frame = 2;
            options.may_map = may_map;
            const auto volume = read_volume(path, options);
            ASSERT_TRUE(volume.ok()) << volume.error().message;
            const auto& voxels = std::get<0>(volume->voxels);
            std::size_t wrong = 0;
            for (std::size_t n = 0; n < kCount; ++n)
                wrong += voxels[n] != std::int16_t(n % 9973 + 20000);
            EXPECT_EQ(wrong, 0u) << adjacent << may_map;
        }
    }
}

TEST(Frames, ACutOffFileIsRefusedForEveryImage) {
    const test::TemporaryFolder folder;
    test::NiftiFile file = nifti_4d();
    file.data.resize(file.data.size() - 2);
    ReadOptions options;
    options.frame = 0;
    const auto volume = read_volume(folder.write("a.nii", file.bytes()), options);
    ASSERT_FALSE(volume.ok());
    EXPECT_NE(volume.error().message.find("ends early"), std::string::npos)
        << volume.error().message;
}

TEST(Frames, AFileWithOneImageHasImageZero) {
    const test::TemporaryFolder folder;
    const auto path = folder.write("a.nrrd", test::NrrdFile().bytes());
    ReadOptions options;
    options.frame = 0;
    EXPECT_TRUE(read_volume(path, options).ok());
    options.frame = 1;
    const auto none = read_volume(path, options);
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().message, "--frame: found 1, expected 0 for " + path.string());
}

TEST(Frames, DamagedFilesDoNoHarm) {
    test::read_damaged("a.nii", nifti_4d().bytes(), 300);
    test::NrrdFile file;
    file.dimension = "4";
    file.sizes = "4 5 3 2";
    file.directions = "(1,0,0) none (0.5,1,0) (0,0,2)";
    file.kinds = "domain time domain domain";
    file.data = packed(numbers(4));
    test::read_damaged("a.nrrd", file.bytes(), 300);
}

TEST(OneSlice, IsReadFromEveryFormat) {
    const test::TemporaryFolder folder;
    test::NrrdFile nrrd;
    nrrd.sizes = "4 6 1";
    test::NrrdFile flat;
    flat.dimension = "2";
    flat.sizes = "4 6";
    flat.directions = "(0,1,0) (0,0,1)";
    flat.kinds = "domain domain";
    test::MetaFile meta;
    meta.dimension = "2";
    meta.sizes = "4 6";
    meta.spacing = "1 3";
    meta.offset = "7 8";
    meta.matrix = "0 1 -1 0";
    test::NiftiFile nifti;
    nifti.dim = {2, 4, 6, 1, 1, 1, 1, 1};
    nifti.pixdim = {1, 1, 1, 0, 0, 0, 0, 0};
    nifti.sform_code = 0;
    const std::filesystem::path paths[] = {
        folder.write("a.nrrd", nrrd.bytes()), folder.write("b.nrrd", flat.bytes()),
        folder.write("c.mha", meta.bytes()), folder.write("d.nii", nifti.bytes())};
    for (const auto& path : paths) {
        const auto volume = read_volume(path);
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        EXPECT_EQ(volume->grid.size, (Vec3i{4, 6, 1})) << path;
        EXPECT_EQ(volume->at({3, 5, 0}), -77) << path;
    }
    const auto oblique = read_volume(paths[1]);
    EXPECT_EQ(oblique->grid.direction.columns[2], (Vec3d{1, 0, 0}));
    const auto placed = read_volume(paths[2]);
    EXPECT_EQ(placed->grid.origin_mm, (Vec3d{7, 8, 0}));
    EXPECT_EQ(placed->grid.spacing_mm, (Vec3d{1, 3, 1}));
    EXPECT_EQ(placed->grid.direction, (Mat3d{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}}));
}

}  // namespace
}  // namespace pliant
