// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Jacobian and strain of affine maps, for which both are known.
// Covers: resample/fields.cpp.

#include "resample/fields.h"

#include <gtest/gtest.h>

#include <cmath>

#include "resample/lattices.h"
#include "support/random.h"

namespace pliant::test {
namespace {

/// u = G·X with X in millimetres, over the whole scan and one element around it.
Lattice affine_lattice(const Volume& volume, const Mat3d& g) {
    const Vec3i n = volume.grid.size;
    const Vec3d h = volume.grid.spacing_mm;
    return displaced_lattice(volume, {{-1, -1, -1}, {n.x + 1, n.y + 1, n.z + 1}}, [&](Vec3d p) {
        return g * Vec3d{p.x * h.x, p.y * h.y, p.z * h.z};
    });
}

Volume blank(Vec3i size, Vec3d spacing_mm) {
    return make_volume(size, spacing_mm, [](Vec3d) { return std::int16_t(0); });
}

TEST(Strain, RandomAffineMapsHaveTheirDeterminant) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume volume = blank({11, 9, 10}, {random.real(0.5, 2), random.real(0.5, 2), 1.7});
        Mat3d g;
        for (auto& column : g.columns) column = random.vector(0.3);
        Mat3d f = g;
        for (int a = 0; a < 3; ++a) f.columns[a][a] += 1;
        const Volume jacobian = jacobian_of_field(affine_lattice(volume, g), arena);
        EXPECT_EQ(jacobian.grid, volume.grid);
        for (const float value : std::get<VoxelArray<float>>(jacobian.voxels))
            ASSERT_NEAR(value, determinant(f), 2e-5);
    }
}

TEST(Strain, AStretchTurnedByARotationHasItsLargestPrincipalStrain) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume volume = blank({9, 9, 9}, {1, 0.8, 1.5});
        // F = R·Q·S·Qᵀ: stretched along the columns of Q, then rotated.
        const Mat3d q = random.rotation(false), r = random.rotation(false);
        const double s[3] = {random.real(0.7, 1.3), random.real(0.7, 1.3), random.real(0.7, 1.3)};
        Mat3d stretched = q;
        for (int a = 0; a < 3; ++a) stretched.columns[a] = s[a] * q.columns[a];
        Mat3d g = r * stretched * transposed(q);
        for (int a = 0; a < 3; ++a) g.columns[a][a] -= 1;
        const double most = std::max({s[0], s[1], s[2]});
        const Volume strain = strain_of_field(affine_lattice(volume, g), arena);
        for (const float value : std::get<VoxelArray<float>>(strain.voxels))
            ASSERT_NEAR(value, (most * most - 1) / 2, 2e-5);
    }
}

TEST(Strain, AtRestNothingIsStrained) {
    const TaskArena arena(1);
    const Volume volume = blank({20, 20, 20}, {1, 1, 1});
    const Lattice lattice = displaced_lattice(volume, {{4, 4, 4}, {8, 8, 8}}, [](Vec3d) {
        return Vec3d{0.1, 0, 0};
    });
    const Volume jacobian = jacobian_of_field(lattice, arena);
    const Volume strain = strain_of_field(lattice, arena);
    EXPECT_EQ(jacobian.at({15, 15, 15}), 1);
    EXPECT_EQ(strain.at({15, 15, 15}), 0);
    EXPECT_EQ(jacobian.at({6, 6, 6}), 1);  // moved as a rigid body
    EXPECT_NEAR(jacobian.at({3, 5, 5}), 1.05, 1e-6);
    EXPECT_NEAR(jacobian.at({8, 5, 5}), 0.95, 1e-6);
}

TEST(Strain, ACutIsNoStrain) {
    const TaskArena arena(1);
    const Volume volume = blank({16, 16, 16}, {1, 1, 1});
    Lattice lattice = displaced_lattice(volume, {{8, 0, 0}, {16, 16, 16}}, [](Vec3d) {
        return Vec3d{2, 0, 0};
    });
    EXPECT_NEAR(jacobian_of_field(lattice, arena).at({7, 8, 8}), 2, 1e-6);
    for (int z = 0; z < 16; ++z)
        for (int y = 0; y < 16; ++y) edit(lattice, {7, y, z}, kCutX);
    const Volume jacobian = jacobian_of_field(lattice, arena);
    EXPECT_NEAR(jacobian.at({7, 8, 8}), 1, 1e-6);
    EXPECT_NEAR(jacobian.at({8, 8, 8}), 1, 1e-6);
}

}  // namespace
}  // namespace pliant::test
