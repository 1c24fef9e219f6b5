// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Value ranges of `pliant info`, against sorting.
// Covers: pliant/value_range.cpp.

#include <gtest/gtest.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

template <class T>
void expect_percentiles(std::vector<T> values, Vec3i size) {
    const TemporaryFolder folder;
    Volume volume;
    volume.grid.size = size;
    volume.voxels = values;
    ASSERT_TRUE(write_volume(folder / "a.nrrd", volume, Encoding::Raw).ok());
    const std::string command =
        "cd '" + folder.path().string() + "' && '" PLIANT_PROGRAM "' info a.nrrd --json > i.json";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const auto json = nlohmann::json::parse(std::ifstream(folder / "i.json"));
    std::sort(values.begin(), values.end());
    EXPECT_EQ(json["voxel_type"], sizeof(T) == 2 ? "int16" : "float32");
    EXPECT_EQ(json["min"], double(values.front()));
    EXPECT_EQ(json["max"], double(values.back()));
    for (const int percent : {1, 5, 25, 50, 75, 95, 99}) {
        const auto rank = std::size_t(std::llround(percent / 100.0 * double(values.size() - 1)));
        EXPECT_EQ(json["percentiles"][std::to_string(percent)], double(values[rank])) << percent;
    }
}

TEST(ValueRange, IsThatOfTheSortedValues) {
    const std::uint64_t seed = 20263;
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    for (const Vec3i size : {Vec3i{2, 2, 2}, Vec3i{21, 13, 17}, Vec3i{90, 80, 79}}) {
        std::vector<std::int16_t> whole(std::size_t(size.x) * size.y * size.z);
        for (auto& v : whole) v = std::int16_t(random.whole(-32768, 32767) / random.whole(1, 50));
        expect_percentiles(whole, size);
        std::vector<float> real(whole.size());
        for (auto& v : real)
            v = float(random.whole(0, 1) ? random.real(-1, 1) : random.real(-2000, 1e5));
        expect_percentiles(real, size);
        for (auto& v : real) v = std::abs(v) < 1 ? -0.25f : 0.1f + std::round(v);
        expect_percentiles(real, size);
    }
}

TEST(Info, WritesTheMatrixByRows) {
    const TemporaryFolder folder;
    Volume volume;
    volume.grid = {{3, 3, 3}, {1, 2, 3}, {10, 20, 30}, {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}}};
    volume.voxels = std::vector<std::int16_t>(27);
    ASSERT_TRUE(write_volume(folder / "a.nrrd", volume).ok());
    const std::string command =
        "cd '" + folder.path().string() + "' && '" PLIANT_PROGRAM "' info a.nrrd --json > i.json";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const auto json = nlohmann::json::parse(std::ifstream(folder / "i.json"));
    // world = origin + direction · diag(spacing) · ijk
    const Vec3d ijk{1, 2, 0.5}, world = world_from_voxel(volume.grid, ijk);
    for (int row = 0; row < 3; ++row) {
        double sum = json["origin_mm"][row];
        for (int a = 0; a < 3; ++a)
            sum += double(json["direction"][row][a]) * double(json["spacing_mm"][a]) * ijk[a];
        EXPECT_DOUBLE_EQ(sum, world[row]);
    }
}

TEST(Info, PassesNoControlCharactersOfAFileOn) {
    const TemporaryFolder folder;
    Volume volume;
    volume.grid.size = {2, 2, 2};
    volume.voxels = std::vector<std::int16_t>(8);
    volume.key_values = {{"name\x1b]0;owned\a", "value\x1b[2J\nsecond line \xc2\x9b"},
                         {"long", std::string(5000, 'v')}};
    ASSERT_TRUE(write_volume(folder / "a.nrrd", volume).ok());
    const std::string command =
        "cd '" + folder.path().string() + "' && '" PLIANT_PROGRAM "' info a.nrrd > i.txt";
    ASSERT_EQ(std::system(command.c_str()), 0);
    std::ifstream file(folder / "i.txt");
    bool is_shown = false;
    for (std::string line; std::getline(file, line);) {
        EXPECT_LE(line.size(), 330u);
        for (const char c : line) EXPECT_FALSE(c >= 0 && c < ' ') << line;
        EXPECT_EQ(line.find("\xc2\x9b"), line.npos) << line;
        is_shown = is_shown || line.find("name?]0;owned?: value?[2J second line") != line.npos;
    }
    EXPECT_TRUE(is_shown);
}

}  // namespace
}  // namespace pliant::test
