// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: writers/write_vti.cpp.

#include <gtest/gtest.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <cstring>

#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant {
namespace {

template <class T>
void expect_written(const char* type) {
    const test::TemporaryFolder folder;
    test::Random random(4);
    Volume volume;
    volume.grid = {.size = {3, 4, 2}, .spacing_mm = {0.5, 1, 2}, .origin_mm = {-1, 2.5, 7}};
    volume.grid.direction = {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}};
    std::vector<T> values(24);
    for (T& v : values) v = T(random.whole(-1000, 1000));
    volume.voxels = std::vector<T>(values);
    ASSERT_TRUE(write_vti(folder / "a.vti", volume).ok());
    const std::string file = test::bytes_of(folder / "a.vti");
    for (const std::string& part :
         {std::string("WholeExtent=\"0 2 0 3 0 1\""), std::string("Origin=\"-1 2.5 7\""),
          std::string("Spacing=\"0.5 1 2\""), std::string("Direction=\"0 0 1 1 0 0 0 1 0\""),
          std::string("type=\"") + type + "\""})
        EXPECT_NE(file.find(part), file.npos) << part;
    ASSERT_TRUE(write_volume(folder / "b.VTI", volume).ok());
    EXPECT_EQ(test::bytes_of(folder / "b.VTI"), file);
    // The length in bytes, then the voxels.
    const auto at = file.find("\n_") + 2;
    std::uint64_t length = 0;
    std::memcpy(&length, file.data() + at, sizeof length);
    ASSERT_EQ(length, 24 * sizeof(T));
    EXPECT_EQ(std::memcmp(file.data() + at + 8, values.data(), length), 0);
    EXPECT_EQ(file.substr(at + 8 + length), "\n</AppendedData>\n</VTKFile>\n");
    EXPECT_EQ(write_vti(folder / "a.vti", volume, "a\"b").error().message,
              (folder / "a.vti").string() + ": the name 'a\"b' of its values can't stand in XML");
}

TEST(WriteVti, VoxelsAndGridAreWrittenAsTheyAre) {
    expect_written<std::int16_t>("Int16");
    expect_written<float>("Float32");
}

}  // namespace
}  // namespace pliant
