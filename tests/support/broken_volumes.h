// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Volumes as a host may fill them in: random good ones, and ones with a single field that is wrong.

#pragma once

#include <gtest/gtest.h>
#include <pliant/volume.h>

#include <cmath>
#include <limits>
#include <string>

#include "support/random.h"

namespace pliant::test {

inline constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Float or 16-bit values of tissue on an oblique grid of `smallest`…12 voxels along each axis.
inline Volume good_volume(Random& random, int smallest = 4) {
    Volume volume;
    Grid& grid = volume.grid;
    for (int a = 0; a < 3; ++a) {
        grid.size[a] = random.whole(smallest, 12);
        grid.spacing_mm[a] = random.ratio(0.1, 5);
    }
    grid.origin_mm = random.vector(200);
    grid.direction = random.rotation(random.whole(0, 1) == 1);
    if (random.whole(0, 1)) {
        std::vector<std::int16_t> values(voxel_count(grid));
        for (auto& v : values) v = std::int16_t(random.whole(-1024, 400));
        volume.voxels = values;
    } else {
        std::vector<float> values(voxel_count(grid));
        for (auto& v : values) v = float(random.real(-1024, 400));
        volume.voxels = values;
    }
    return volume;
}

struct BrokenVolume {
    Volume volume;
    std::string field;  ///< the wrong field
};

inline BrokenVolume broken_volume(Random& random) {
    BrokenVolume broken{good_volume(random), {}};
    Volume& volume = broken.volume;
    Grid& grid = volume.grid;
    const int axis = random.whole(0, 2);
    Vec3d& column = grid.direction.columns[std::size_t(axis)];
    const Vec3d next = grid.direction.columns[std::size_t((axis + 1) % 3)];
    const auto one_of = [&](std::initializer_list<double> values) {
        return values.begin()[random.whole(0, int(values.size()) - 1)];
    };
    const auto with_voxels = [&](std::size_t count) {
        if (volume.is_16_bit())
            volume.voxels = VoxelArray<std::int16_t>(count);
        else
            volume.voxels = VoxelArray<float>(count);
        broken.field = "voxels";
    };
    switch (random.whole(0, 7)) {
        case 0:
            with_voxels(std::size_t(random.whole(0, int(voxel_count(grid)) - 1)));
            break;
        case 1:
            with_voxels(voxel_count(grid) + std::size_t(random.whole(1, 100)));
            break;
        case 2:
            grid.size[axis] = int(one_of({0, -1, -4, -2147483648.0, 70000, 2147483647}));
            broken.field = "grid.size";
            break;
        case 3:
            grid.spacing_mm[axis] =
                one_of({0, -0.0, -1, 1e-9, 1e9, kNotANumber, kInfinity, -kInfinity});
            broken.field = "grid.spacing_mm";
            break;
        case 4:
            grid.origin_mm[axis] = one_of({kNotANumber, kInfinity, -kInfinity, 1e300});
            broken.field = "grid.origin_mm";
            break;
        case 5:
            column[random.whole(0, 2)] = one_of({kNotANumber, kInfinity, 1e200});
            broken.field = "grid.direction";
            break;
        case 6:  // singular
            column = random.whole(0, 1) ? next : Vec3d{0, 0, 0};
            broken.field = "grid.direction";
            break;
        default:  // sheared, or not of unit length
            column = random.whole(0, 1) ? normalized(column + random.ratio(0.01, 1) * next)
                                        : random.ratio(1.01, 100) * column;
            broken.field = "grid.direction";
    }
    return broken;
}

/// A volume of floats some of which are no numbers, infinite or huge.
inline Volume volume_with_strange_values(Random& random) {
    Volume volume = good_volume(random);
    std::vector<float> values(voxel_count(volume.grid));
    for (auto& v : values) v = float(random.real(-1024, 400));
    for (int n = random.whole(1, 40); n > 0; --n) {
        const float strange[] = {float(kNotANumber), float(kInfinity), -float(kInfinity), 3e38F,
                                 -3e38F};
        values[std::size_t(random.whole(0, int(values.size()) - 1))] = strange[random.whole(0, 4)];
    }
    volume.voxels = values;
    return volume;
}

/// One line that names the field, the expected and the found value.
inline void expect_refused(const Error& error, const std::string& field) {
    for (const std::string& word : {field, std::string("expected"), std::string("found")})
        EXPECT_NE(error.message.find(word), std::string::npos) << word << ": " << error.message;
    EXPECT_EQ(error.message.find('\n'), std::string::npos) << error.message;
}
template <class T>
void expect_refused(const Result<T>& result, const std::string& field) {
    ASSERT_FALSE(result.ok()) << field << " was accepted";
    expect_refused(result.error(), field);
}

}  // namespace pliant::test
