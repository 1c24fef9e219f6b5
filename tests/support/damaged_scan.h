// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files with bytes changed, cut out or cut off anywhere, and the allowed results of reading them.

#pragma once

#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace pliant::test {

inline std::string damaged(std::string bytes, std::mt19937& random) {
    const auto place = [&](std::size_t size) {
        return std::uniform_int_distribution<std::size_t>(0, size)(random);
    };
    switch (place(3)) {
        case 0:
            bytes.resize(place(bytes.size()));
            break;
        case 1:
            bytes.erase(place(bytes.size()), place(8));
            break;
        case 2:
            bytes.insert(place(bytes.size()), std::string(place(8), char(place(255))));
            break;
        default:
            break;
    }
    for (std::size_t n = place(3); n > 0 && !bytes.empty(); --n)
        bytes[place(bytes.size() - 1)] = char(place(255));
    return bytes;
}

inline void expect_one_line_or_a_sound_volume(const Result<Volume>& volume) {
    if (!volume.ok()) {
        EXPECT_EQ(volume.error().message.find('\n'), std::string::npos) << volume.error().message;
        return;
    }
    const std::size_t count = voxel_count(volume->grid);
    std::visit([&](const auto& voxels) { EXPECT_EQ(voxels.size(), count); }, volume->voxels);
    for (int a = 0; a < 3; ++a) {
        EXPECT_GE(volume->grid.size[a], 1);
        EXPECT_GT(volume->grid.spacing_mm[a], 0);
        EXPECT_TRUE(is_finite(volume->grid.direction.columns[a]));
    }
    EXPECT_TRUE(is_finite(volume->grid.origin_mm));
}

/// Reads damaged copies of a file, with and without options.
inline void read_damaged(const std::string& name, const std::string& good, int count,
                         unsigned seed = 4711) {
    const TemporaryFolder folder;
    std::mt19937 random(seed);
    ReadOptions options;
    options.frame = 0;
    options.straighten = true;
    testing::internal::CaptureStderr();
    for (int n = 0; n < count; ++n) {
        std::filesystem::remove(folder / name);
        const auto path = folder.write(name, damaged(good, random));
        expect_one_line_or_a_sound_volume(n % 2 ? read_volume(path) : read_volume(path, options));
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << name << ", seed " << seed;
}

}  // namespace pliant::test
