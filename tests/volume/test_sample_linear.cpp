// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: pliant/volume.h.

#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace pliant {
namespace {

/// A field that trilinear interpolation reproduces.
double linear_field_at(Vec3d p) {
    return 3 * p.x - 2 * p.y + 5 * p.z + 0.5 * p.x * p.y * p.z - 40;
}

Volume field_volume() {
    Volume volume;
    volume.grid.size = {5, 4, 3};
    std::vector<float> voxels;
    for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 5; ++i)
                voxels.push_back(float(linear_field_at({double(i), double(j), double(k)})));
    volume.voxels = std::move(voxels);
    return volume;
}

TEST(SampleLinear, ReproducesTrilinearFieldsInside) {
    const Volume volume = field_volume();
    const unsigned seed = 20260;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int n = 0; n < 1000; ++n) {
        const Vec3d p{4 * unit(random), 3 * unit(random), 2 * unit(random)};
        ASSERT_NEAR(sample_linear(volume, p), linear_field_at(p), 1e-4) << "seed " << seed;
    }
}

TEST(SampleLinear, GivesVoxelsBackAtTheirCentres) {
    const Volume volume = field_volume();
    EXPECT_EQ(sample_linear(volume, {4, 3, 2}), volume.at({4, 3, 2}));
    EXPECT_EQ(sample_linear(volume, {0, 0, 0}), volume.at({0, 0, 0}));
}

TEST(SampleLinear, FadesToAirOverOneVoxelAtTheBorder) {
    const Volume volume = field_volume();
    EXPECT_NEAR(sample_linear(volume, {-0.25, 0, 0}), 0.75 * linear_field_at({0, 0, 0}) - 250,
                1e-3);
    EXPECT_NEAR(sample_linear(volume, {4.5, 3, 2}), 0.5 * linear_field_at({4, 3, 2}) - 500, 1e-3);
    EXPECT_EQ(sample_linear(volume, {-1, 0, 0}), float(kAirHu));
    EXPECT_EQ(sample_linear(volume, {5, 0, 0}), float(kAirHu));
    EXPECT_EQ(sample_linear(volume, {0, 1e30, 0}), float(kAirHu));
    EXPECT_EQ(sample_linear(volume, {0, 0, std::numeric_limits<double>::quiet_NaN()}),
              float(kAirHu));
    Volume other = volume;
    other.background = 7;
    EXPECT_NEAR(sample_linear(other, {4.5, 3, 2}), 0.5 * linear_field_at({4, 3, 2}) + 3.5, 1e-3);
    EXPECT_EQ(sample_linear(other, {5, 0, 0}), 7);
}

}  // namespace
}  // namespace pliant
