// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Fields by themselves. SimpleITK is the oracle of the Python module's tests; here affine maps are,
// whose values are known in closed form.

#include <gtest/gtest.h>
#include <pliant/resample.h>

#include <cstdio>
#include <random>

namespace pliant::test {
namespace {

/// u(X) = A (X − origin) + b on an oblique, left-handed grid, or a right-handed one.
struct Affine {
    explicit Affine(unsigned seed) : random(seed) {
        field.grid = {{7, 6, 5}, {number(0.5, 2), number(0.5, 2), number(0.5, 2)}, point(10), {}};
        const Vec3d x = normalized(point(1)), y = normalized(cross(x, point(1)));
        field.grid.direction = {{x, y, seed % 2 ? cross(x, y) : cross(y, x)}};
        for (Vec3d& column : a.columns) column = point(0.1);
        b = point(0.5);
        for (int k = 0; k < 5; ++k)
            for (int j = 0; j < 6; ++j)
                for (int i = 0; i < 7; ++i) {
                    const Vec3d u =
                        at(world_from_voxel(field.grid, {double(i), double(j), double(k)}));
                    field.vectors_mm.push_back({float(u.x), float(u.y), float(u.z)});
                }
    }
    double number(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    }
    Vec3d point(double most) { return {number(-most, most), number(-most, most), number(0, most)}; }
    Vec3d at(Vec3d x) const { return a * (x - field.grid.origin_mm) + b; }

    std::mt19937 random;
    Mat3d a{};
    Vec3d b{};
    VectorField field;
};

unsigned seed_of(unsigned n) {
    const unsigned seed = std::random_device()() / 2 * 2 + n % 2;
    std::printf("seed %u\n", seed);
    return seed;
}

TEST(ApplyField, AnAffineFieldIsInterpolatedExactlyAndIsZeroBeyondTheGrid) {
    for (unsigned n = 0; n < 10; ++n) {
        Affine affine(seed_of(n));
        const Grid& grid = affine.field.grid;
        for (int p = 0; p < 50; ++p) {
            const Vec3d inside = world_from_voxel(
                grid, {affine.number(0, 6), affine.number(0, 5), affine.number(0, 4)});
            EXPECT_LT(norm(sample_field(affine.field, inside) - affine.at(inside)), 1e-5);
        }
        EXPECT_EQ(sample_field(affine.field, world_from_voxel(grid, {-0.01, 2, 2})),
                  (Vec3d{0, 0, 0}));
        EXPECT_EQ(sample_field(affine.field, world_from_voxel(grid, {2, 2, 4.01})),
                  (Vec3d{0, 0, 0}));
    }
}

TEST(ApplyField, VoxelCentresAtTheBorderAreInsideWhenRoundingMovesThem) {
    for (unsigned n = 0; n < 10; ++n) {
        const Affine affine(seed_of(n));
        VectorField rounded = affine.field;
        for (int a = 0; a < 3; ++a) rounded.grid.origin_mm[a] = float(rounded.grid.origin_mm[a]);
        const Vec3i size = rounded.grid.size;
        for (int c = 0; c < 8; ++c) {
            const Vec3d corner{(c & 1) * (size.x - 1.0), (c >> 1 & 1) * (size.y - 1.0),
                               (c >> 2) * (size.z - 1.0)};
            const Vec3d point = world_from_voxel(affine.field.grid, corner);
            EXPECT_LT(norm(sample_field(rounded, point) - affine.at(point)), 1e-3);
        }
    }
}

TEST(ApplyField, TheJacobianOfAnAffineFieldIsItsDeterminant) {
    for (unsigned n = 0; n < 10; ++n) {
        Affine affine(seed_of(n));
        Mat3d f = affine.a;
        for (int c = 0; c < 3; ++c) f.columns[c] = f.columns[c] + kIdentity3.columns[c];
        const auto jacobian = jacobian_field(affine.field);
        ASSERT_TRUE(jacobian.ok());
        for (int k = 0; k < 5; ++k)
            for (int j = 0; j < 6; ++j)
                for (int i = 0; i < 7; ++i)
                    EXPECT_NEAR(jacobian->at({i, j, k}), determinant(f), 1e-5);
    }
}

TEST(ApplyField, ALinearVolumeIsResampledExactly) {
    for (unsigned n = 0; n < 4; ++n) {
        Affine affine(seed_of(n));
        affine.field.kind = FieldKind::Resampling;
        const Grid& grid = affine.field.grid;
        const Vec3d slope = affine.point(1);
        Volume volume{grid, VoxelArray<float>(voxel_count(grid)), {}, 1e4F};
        for (int k = 0; k < 5; ++k)
            for (int j = 0; j < 6; ++j)
                for (int i = 0; i < 7; ++i)
                    std::get_if<1>(&volume.voxels)->data()[voxel_index(grid, {i, j, k})] = float(
                        dot(slope, world_from_voxel(grid, {double(i), double(j), double(k)})));
        const TaskArena one(1), two(2);
        const auto out = apply_field(affine.field, volume, one);
        ASSERT_TRUE(out.ok()) << out.error().message;
        int inside = 0;
        for (int k = 0; k < 5; ++k)
            for (int j = 0; j < 6; ++j)
                for (int i = 0; i < 7; ++i) {
                    const Vec3d x = world_from_voxel(grid, {double(i), double(j), double(k)});
                    const Vec3d from = x + affine.at(x), ijk = voxel_from_world(grid, from);
                    if (!(ijk.x > 0 && ijk.x < 6 && ijk.y > 0 && ijk.y < 5 && ijk.z > 0 &&
                          ijk.z < 4))
                        continue;
                    ++inside;
                    EXPECT_NEAR(out->at({i, j, k}), dot(slope, from), 1e-4);
                }
        EXPECT_GT(inside, 20);
        const auto again = apply_field(affine.field, volume, two);
        ASSERT_TRUE(again.ok());
        EXPECT_EQ(hash_volume(*out), hash_volume(*again));
        affine.field.kind = FieldKind::Modeling;
        EXPECT_FALSE(apply_field(affine.field, volume, one).ok());
    }
}

}  // namespace
}  // namespace pliant::test
