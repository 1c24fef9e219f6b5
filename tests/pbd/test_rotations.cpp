// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rotations against the functions that define them.

#include <gtest/gtest.h>

#include <cmath>

#include "pbd/rotations.h"
#include "support/random.h"

namespace pliant::test {
namespace {

// Small turns go without trigonometric functions, on both sides of where that ends.
TEST(Rotation, SmallTurnsAreWhatTheFunctionsSay) {
    for (std::uint64_t seed = 1; seed <= 400; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const double angle = seed % 2 ? random.ratio(1e-9, 3) : random.real(0.19, 0.21);
        const Vec3d r = angle * normalized(random.vector(1)), v = random.vector(1);
        const Rotation q = rotation_by(r), found = pbd::turn_by(r);
        for (const double off : {found.w - q.w, found.x - q.x, found.y - q.y, found.z - q.z})
            EXPECT_LT(std::abs(off), 4e-16);
        for (const double sign : {1.0, -1.0}) {
            const Rotation same{sign * q.w, sign * q.x, sign * q.y, sign * q.z};
            EXPECT_LT(norm(pbd::turn_of(same) - r), 1e-15 * angle + 1e-18);
        }
        // By its definition: the change of the logarithm for a small turn before.
        const double step = 1e-5;
        const Vec3d change = (0.5 / step) * (rotation_vector(rotation_by(step * v) * q) -
                                             rotation_vector(rotation_by(-step * v) * q));
        const Mat3d derivative = pbd::log_derivative(r);
        EXPECT_LT(norm(derivative * v - change), 1e-8);
        const Vec3d across = pbd::log_transposed(r, pbd::log_curvature(dot(r, r)), v);
        EXPECT_LT(norm(transposed(derivative) * v - across), 1e-14);
    }
}

TEST(Rotation, RotationsAreTheirVectors) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const Vec3d r = random.ratio(1e-9, 3) * normalized(random.vector(1));
        const Vec3d back = rotation_vector(rotation_by(r));
        EXPECT_LT(norm(back - r), 1e-12);
        // Rodrigues' formula.
        const Vec3d v = random.vector(1), axis = normalized(r);
        const double angle = norm(r);
        const Vec3d expected = std::cos(angle) * v + std::sin(angle) * cross(axis, v) +
                               (1 - std::cos(angle)) * dot(axis, v) * axis;
        EXPECT_LT(norm(rotated(rotation_by(r), v) - expected), 1e-12);
        const Rotation other = rotation_by(random.vector(1));
        EXPECT_LT(norm(rotated(other * rotation_by(r), v) - rotated(other, expected)), 1e-12);
    }
}

}  // namespace
}  // namespace pliant::test
