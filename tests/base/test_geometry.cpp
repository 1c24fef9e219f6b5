// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: pliant/volume.h.

#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace pliant {
namespace {

void expect_near(Vec3d found, Vec3d expected, double tolerance) {
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(found[a], expected[a], tolerance);
}

TEST(Vectors, ObeyTheirIdentities) {
    const Vec3d a{1, 2, 3}, b{-4, 5, 0.5};
    EXPECT_EQ(dot(a, cross(a, b)), 0);
    EXPECT_EQ(dot(b, cross(a, b)), 0);
    EXPECT_EQ(cross(a, b), -cross(b, a));
    EXPECT_EQ((cross(Vec3d{1, 0, 0}, Vec3d{0, 1, 0})), (Vec3d{0, 0, 1}));
    EXPECT_DOUBLE_EQ(norm(normalized(b)), 1);
    EXPECT_EQ(norm({3, 4, 12}), 13);
    EXPECT_FALSE(is_finite({0, std::numeric_limits<double>::quiet_NaN(), 0}));
}

TEST(Matrices, TimesTheirInverseAreTheIdentity) {
    const unsigned seed = 5;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    for (int n = 0; n < 100; ++n) {
        Mat3d m;
        for (Vec3d& column : m.columns) column = {number(random), number(random), number(random)};
        if (std::abs(determinant(m)) < 0.05) continue;
        const Mat3d product = m * inverse(m);
        for (int c = 0; c < 3; ++c) expect_near(product.columns[c], kIdentity3.columns[c], 1e-12);
        EXPECT_EQ(transposed(transposed(m)), m) << "seed " << seed;
        EXPECT_NEAR(determinant(transposed(m)), determinant(m), 1e-15);
    }
}

TEST(Matrices, HaveTheImagesOfUnitVectorsAsColumns) {
    const Mat3d m = {{{1, 2, 3}, {4, 5, 6}, {7, 8, 10}}};
    EXPECT_EQ((m * Vec3d{0, 1, 0}), (Vec3d{4, 5, 6}));
    EXPECT_EQ(determinant(m), -3);
}

TEST(Grids, GoFromVoxelsToTheWorldAndBack) {
    const Vec3d k = normalized({1, 2, 3}), i = normalized(cross(k, {0, 0, 1}));
    for (const double hand : {1.0, -1.0}) {
        const Grid grid{{7, 8, 9}, {0.5, 1, 3}, {-10, 20, 5}, {{i, hand * cross(k, i), k}}};
        expect_near(world_from_voxel(grid, {0, 0, 0}), grid.origin_mm, 0);
        expect_near(world_from_voxel(grid, {2, 0, 0}), grid.origin_mm + i, 1e-14);
        const Vec3d v{1.25, 6.5, -3};
        expect_near(voxel_from_world(grid, world_from_voxel(grid, v)), v, 1e-12);
        expect_near(lattice_from_world_vector(grid, world_from_lattice_vector(grid, v)), v, 1e-13);
        EXPECT_NEAR(norm(world_from_lattice_vector(grid, v)), norm(v), 1e-13);
    }
}

TEST(Grids, NumberVoxelsWithIFastest) {
    const Grid grid{{3, 4, 5}, {1, 1, 1}, {0, 0, 0}, kIdentity3};
    EXPECT_EQ(voxel_count(grid), 60u);
    EXPECT_EQ(voxel_index(grid, {1, 0, 0}), 1u);
    EXPECT_EQ(voxel_index(grid, {0, 1, 0}), 3u);
    EXPECT_EQ(voxel_index(grid, {2, 3, 4}), 59u);
    const Grid large{{2000, 2000, 2000}, {1, 1, 1}, {0, 0, 0}, kIdentity3};
    EXPECT_EQ(voxel_index(large, {1999, 1999, 1999}) + 1, voxel_count(large));
}

TEST(Boxes, HoldTheirBeginButNotTheirEnd) {
    const Box3i box{{1, 2, 3}, {4, 5, 6}};
    EXPECT_TRUE(contains(box, {1, 2, 3}));
    EXPECT_TRUE(contains(box, {3, 4, 5}));
    EXPECT_FALSE(contains(box, {4, 4, 5}));
    EXPECT_FALSE(contains(box, {1, 2, 2}));
    EXPECT_FALSE(is_empty(box));
    EXPECT_TRUE(is_empty({{1, 2, 3}, {4, 2, 6}}));
}

}  // namespace
}  // namespace pliant
