// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scans written as MetaImage and NIfTI come back to the bit, except for NIfTI's rounding of
// positions to 32-bit floats.
// Covers: writers/image_sink.cpp, writers/meta_writer.cpp, writers/nifti_writer.cpp.

#include "support/random.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <cstring>

namespace pliant {
namespace {

namespace fs = std::filesystem;

Volume random_scan(test::Random& random, bool narrow, bool mirrored) {
    Volume volume;
    volume.grid.size = {random.whole(2, 9), random.whole(2, 9), random.whole(2, 9)};
    volume.grid.spacing_mm = {random.real(0.01, 5), random.real(0.01, 5), random.real(0.01, 5)};
    volume.grid.origin_mm = {random.real(-2000, 2000), random.real(-2000, 2000),
                             random.real(-2000, 2000)};
    volume.grid.direction = random.rotation(mirrored);
    const std::size_t count = voxel_count(volume.grid);
    if (narrow) {
        auto& voxels = volume.voxels.emplace<0>(count);
        for (std::int16_t& v : voxels) v = std::int16_t(random.whole(-32768, 32767));
    } else {
        auto& voxels = volume.voxels.emplace<1>(count);
        for (float& v : voxels) v = float(random.real(-5000, 5000));
    }
    return volume;
}

/// Largest distance between the positions of a corner in two grids [mm].
double corner_distance_mm(const Grid& a, const Grid& b) {
    double largest = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d ijk{corner & 1 ? a.size.x - 1.0 : 0, corner & 2 ? a.size.y - 1.0 : 0,
                        corner & 4 ? a.size.z - 1.0 : 0};
        largest = std::max(largest, norm(world_from_voxel(a, ijk) - world_from_voxel(b, ijk)));
    }
    return largest;
}

Volume written_and_read(const fs::path& path, const Volume& volume, Encoding encoding) {
    const Status status = write_volume(path, volume, encoding);
    EXPECT_TRUE(status.ok()) << status.error().message;
    ReadNotes notes;
    auto again = read_volume(path, {}, &notes);
    EXPECT_TRUE(again.ok()) << again.error().message;
    EXPECT_TRUE(notes.notes.empty()) << notes.notes[0];
    EXPECT_EQ(notes.stored_type, volume.is_16_bit() ? "int16" : "float32");
    return again.ok() ? std::move(*again) : Volume{};
}

TEST(WriteFormats, MetaImagesComeBackToTheBit) {
    const test::TemporaryFolder folder;
    test::Random random(11);
    for (int n = 0; n < 40; ++n)
        for (const char* name : {"a.mha", "b.mhd"}) {
            const Volume volume = random_scan(random, n % 2 == 0, n % 3 == 0);
            const Volume again =
                written_and_read(folder / name, volume, n % 4 < 2 ? Encoding::Gzip : Encoding::Raw);
            EXPECT_EQ(again.voxels, volume.voxels);
            EXPECT_EQ(again.grid.spacing_mm, volume.grid.spacing_mm);
            EXPECT_EQ(again.grid.origin_mm, volume.grid.origin_mm);
            EXPECT_LT(corner_distance_mm(again.grid, volume.grid), 1e-12);
        }
}

TEST(WriteFormats, NiftiComesBackWithPositionsInFloats) {
    const test::TemporaryFolder folder;
    test::Random random(12);
    for (int n = 0; n < 60; ++n)
        for (const char* name : {"a.nii", "b.nii.gz"}) {
            const Volume volume = random_scan(random, n % 2 == 0, n % 3 == 0);
            const Volume again = written_and_read(folder / name, volume, Encoding::Raw);
            EXPECT_EQ(again.voxels, volume.voxels);
            EXPECT_EQ(determinant(again.grid.direction) > 0, n % 3 != 0);
            for (int a = 0; a < 3; ++a)
                EXPECT_EQ(again.grid.spacing_mm[a], double(float(volume.grid.spacing_mm[a])));
            // Floats near 2000 mm are 1.2e-4 mm apart.
            EXPECT_LT(corner_distance_mm(again.grid, volume.grid), 2e-4) << n;
        }
}

/// Positions by the quaternion alone, as programs that ignore the sform compute them.
TEST(WriteFormats, TheQformOfNiftiAgreesWithItsSform) {
    const test::TemporaryFolder folder;
    test::Random random(13);
    for (int n = 0; n < 60; ++n) {
        Volume volume = random_scan(random, true, n % 3 == 0);
        if (n == 0) volume.grid.direction = {{{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};
        ASSERT_TRUE(write_volume(folder / "a.nii", volume).ok());
        std::string bytes = test::bytes_of(folder / "a.nii");
        bytes[254] = bytes[255] = 0;  // no sform
        folder.write("a.nii", bytes);
        const auto again = read_volume(folder / "a.nii");
        ASSERT_TRUE(again.ok()) << again.error().message;
        EXPECT_LT(corner_distance_mm(again->grid, volume.grid), 3e-4) << n;
    }
}

TEST(WriteFormats, RawDataCanBeMapped) {
    const test::TemporaryFolder folder;
    Volume volume;
    volume.grid.size = {3, 5, 2};
    volume.key_values = {{"a", "b"}};
    volume.voxels = VoxelArray<float>(std::vector<float>(30, 0.5F));
    ASSERT_TRUE(write_volume(folder / "a.mha", volume, Encoding::Raw).ok());
    const std::string file = test::bytes_of(folder / "a.mha");
    ASSERT_EQ((file.size() - 120) % 64, 0u);
    const std::string header = file.substr(0, file.size() - 120);
    EXPECT_TRUE(header.ends_with("\nElementDataFile = LOCAL\n")) << header;
}

TEST(WriteFormats, AHeaderAndItsDataAreTwoFiles) {
    const test::TemporaryFolder folder;
    test::Random random(3);
    const Volume volume = random_scan(random, true, false);
    ASSERT_TRUE(write_volume(folder / "a.mhd", volume).ok());
    EXPECT_TRUE(fs::exists(folder / "a.zraw"));
    ASSERT_TRUE(write_volume(folder / "b.mhd", volume, Encoding::Raw).ok());
    EXPECT_EQ(fs::file_size(folder / "b.raw"), 2 * voxel_count(volume.grid));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 4);
}

TEST(WriteFormats, CompressedDataHaveTheLengthThatTheHeaderSays) {
    const test::TemporaryFolder folder;
    test::Random random(4);
    ASSERT_TRUE(write_volume(folder / "a.mha", random_scan(random, true, false)).ok());
    const std::string file = test::bytes_of(folder / "a.mha");
    const std::string field = "CompressedDataSize = ", last = "ElementDataFile = LOCAL\n";
    const auto size = std::stoull(file.substr(file.find(field) + field.size(), 20));
    EXPECT_EQ(size, file.size() - file.find(last) - last.size());
}

TEST(WriteFormats, KeysThatMetaImageCannotHoldAreLeftOut) {
    const test::TemporaryFolder folder;
    test::Random random(5);
    Volume volume = random_scan(random, true, false);
    volume.key_values = {{"modality", "CT"},  {"a=b", "x"},    {"DimSize", "9 9 9"},
                         {"two", "one\ntwo"}, {" blank", "x"}, {"colon", ":x"},
                         {"ITK_x", "y"},      {"empty", ""},   {"a key", "of two words"},
                         {"ElementMin", "0"}, {"after", " x"}};
    const Volume again = written_and_read(folder / "a.mha", volume, Encoding::Raw);
    EXPECT_EQ(again.key_values,
              (KeyValues{{"modality", "CT"}, {"empty", ""}, {"a key", "of two words"}}));
    EXPECT_EQ(again.voxels, volume.voxels);
}

TEST(WriteFormats, NiftiRefusesAnAxisThatItsHeaderCannotHold) {
    const test::TemporaryFolder folder;
    Volume volume;
    volume.grid.size = {32768, 1, 1};
    volume.voxels = VoxelArray<std::int16_t>(std::size_t(32768));
    const Status status = write_volume(folder / "a.nii", volume);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().message,
              (folder / "a.nii").string() +
                  ": NIfTI-1 holds up to 32767 voxels along an axis, found 32768");
    EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(WriteFormats, EveryEndingIsListed) {
    const test::TemporaryFolder folder;
    test::Random random(6);
    const Volume volume = random_scan(random, true, false);
    for (const std::string_view ending : volume_endings())
        EXPECT_TRUE(write_volume(folder / ("a" + std::string(ending)), volume).ok()) << ending;
    const Status status = write_volume(folder / "a.png", volume);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().message,
              (folder / "a.png").string() +
                  ": expected a name that ends in .nrrd, .nhdr, .mha, .mhd, .nii, .nii.gz or .vti");
}

}  // namespace
}  // namespace pliant
