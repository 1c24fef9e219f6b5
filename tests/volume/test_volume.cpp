// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include "support/broken_volumes.h"
#include "support/temporary_folder.h"
#include "volume/same_grid.h"

namespace pliant::test {
namespace {

TEST(CheckVolume, EachFieldThatIsWrongIsNamedWithWhatWasExpectedAndFound) {
    const Volume good{{.size = {2, 3, 4}}, VoxelArray<std::int16_t>(std::size_t(24)), {}};
    ASSERT_TRUE(check_volume(good).ok());
    const auto message = [](const Volume& volume) { return check_volume(volume).error().message; };
    Volume bad = good;
    bad.voxels = VoxelArray<float>(std::size_t(10));
    EXPECT_EQ(message(bad), "volume.voxels: expected 24 of them (2 × 3 × 4), found 10");
    bad = good;
    bad.grid.size.y = -4;
    EXPECT_EQ(message(bad), "volume.grid.size.y: expected 1 to 65536 voxels, found -4");
    bad = good;
    bad.grid.spacing_mm.z = -1;
    EXPECT_EQ(message(bad), "volume.grid.spacing_mm.z: expected 1e-06 to 10000 mm, found -1");
    bad = good;
    bad.grid.origin_mm.x = kNotANumber;
    EXPECT_EQ(message(bad),
              "volume.grid.origin_mm.x: expected a number within 1e+08 mm, found nan");
    bad = good;
    bad.grid.direction.columns[1] = {1, 0, 0};
    EXPECT_EQ(message(bad),
              "volume.grid.direction: expected perpendicular unit columns, found (1, 0, 0), "
              "(1, 0, 0), (0, 0, 1)");
    bad = good;
    bad.grid.size = {65536, 65536, 65536};
    EXPECT_EQ(message(bad),
              "volume.grid.size: expected at most 4294967296 voxels, found 281474976710656");
    EXPECT_EQ(check_volume(bad, "labels").error().message.substr(0, 7), "labels.");
    VectorField field{good.grid, FieldKind::Modeling, std::vector<Vec3f>(23)};
    EXPECT_EQ(check_field(field).error().message,
              "field.vectors_mm: expected 24 of them (2 × 3 × 4), found 23");
    field.vectors_mm.resize(24);
    EXPECT_TRUE(check_field(field).ok());
}

TEST(Grids, AreOneUpToTheRoundingOfFiles) {
    const Grid grid{{512, 512, 300}, {0.7, 0.7, 1.25}, {-179.12345678, -201.7, -1432.3}};
    Grid other = grid;
    EXPECT_EQ(corner_distance(grid, other), 0);
    for (int a = 0; a < 3; ++a) {
        other.origin_mm[a] = float(grid.origin_mm[a]);
        other.spacing_mm[a] = float(grid.spacing_mm[a]);
    }
    EXPECT_NE(grid, other);
    EXPECT_TRUE(is_same_grid(grid, other));
    other.origin_mm.y += 0.7 * 0.02;
    EXPECT_FALSE(is_same_grid(grid, other));
    EXPECT_NEAR(corner_distance(other, grid), 0.02, 1e-3);
    other = grid;
    other.direction = {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
    EXPECT_FALSE(is_same_grid(grid, other));
    other = grid;
    other.size.z = 299;
    EXPECT_FALSE(is_same_grid(grid, other));
    other = grid;
    other.origin_mm.x = kNotANumber;
    EXPECT_FALSE(is_same_grid(grid, other));
}

TEST(CheckVolume, RandomVolumesPassAndOnesWithABrokenFieldAreNeverWritten) {
    const TemporaryFolder folder;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        EXPECT_TRUE(check_volume(good_volume(random, 1)).ok());
        const BrokenVolume broken = broken_volume(random);
        expect_refused(check_volume(broken.volume), "volume." + broken.field);
        for (const char* name : {"a.nrrd", "a.nhdr", "a.vti"}) {
            expect_refused(write_volume(folder / name, broken.volume), broken.field);
            EXPECT_FALSE(std::filesystem::exists(folder / name));
        }
        VectorField field{broken.volume.grid, FieldKind::Modeling, {}};
        expect_refused(write_vector_field(folder / "a.nrrd", field), "a.nrrd.");
        const FieldSlices none = [](int, std::span<Vec3f>) {};
        if (broken.field != "voxels")
            expect_refused(
                write_vector_field(folder / "a.nrrd", field.grid, FieldKind::Modeling, none),
                broken.field);
        EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
    }
}

}  // namespace
}  // namespace pliant::test
