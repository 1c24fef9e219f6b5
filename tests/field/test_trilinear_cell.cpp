// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The trilinear map and its inverse against the weights of the corners, and on both sides of each
// threshold.

#include "field/trilinear_cell.h"

#include <gtest/gtest.h>

#include "support/random.h"

namespace pliant::test {
namespace {

using Corners = std::array<Vec3d, 8>;

/// The weight of a corner at cell coordinates t.
double weight(std::size_t corner, Vec3d t) {
    double w = 1;
    for (int a = 0; a < 3; ++a) w *= corner >> a & 1 ? t[a] : 1 - t[a];
    return w;
}

Corners parallelepiped(Vec3d origin, const Mat3d& edges) {
    Corners corners;
    for (std::size_t c = 0; c < 8; ++c)
        corners[c] = origin + edges * Vec3d{double(c & 1), double(c >> 1 & 1), double(c >> 2)};
    return corners;
}

/// A turned box, its corners moved by up to `bend`.
Corners random_cell(Random& random, double bend) {
    const Mat3d turn = random.rotation(false);
    Mat3d edges;
    for (int a = 0; a < 3; ++a) edges.columns[a] = random.real(0.7, 1.5) * turn.columns[a];
    Corners corners = parallelepiped(random.vector(3), edges);
    for (Vec3d& corner : corners) corner = corner + random.vector(bend);
    return corners;
}

Vec3d inner_point(Random& random) {
    return {random.real(0, 1), random.real(0, 1), random.real(0, 1)};
}

TEST(TrilinearCell, MapsAsItsCornersWeightsDoAndBack) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Corners corners = random_cell(random, seed % 2 ? 0.15 : 0);
        const TrilinearCell map(corners);
        std::array<double, 8> values;
        for (double& v : values) v = random.real(-1, 1);
        const Vec3d t = inner_point(random);
        Vec3d expected{0, 0, 0};
        double value = 0;
        for (std::size_t c = 0; c < 8; ++c) {
            expected = expected + weight(c, t) * corners[c];
            value += weight(c, t) * values[c];
        }
        EXPECT_LE(norm(map.at(t) - expected), 1e-14);
        EXPECT_NEAR(interpolate(values, t), value, 1e-15);
        for (const auto& found : {map.locate(expected), map.locate_from_corners(expected, 0)}) {
            ASSERT_TRUE(found);
            EXPECT_LE(norm(*found - t), 1e-13);
        }
    }
}

TEST(TrilinearCell, TakesAPointCloseToAFaceForOneOnIt) {
    constexpr double kOutside = 1e-3;
    for (const double bend : {0.0, 0.1}) {
        Random random(5);
        const TrilinearCell map(random_cell(random, bend));
        for (int a = 0; a < 3; ++a)
            for (const double face : {0.0, 1.0}) {
                const double out = face == 0 ? -1 : 1;
                const auto at = [&](double distance) {
                    Vec3d t{0.3, 0.4, 0.6};
                    t[a] = face + distance * out;
                    return map.locate(map.at(t), kOutside);
                };
                const auto inside = at(-0.01 * kOutside), beside = at(0.99 * kOutside);
                ASSERT_TRUE(inside && beside);
                EXPECT_NEAR((*inside)[a], face - 1e-5 * out, 1e-12);
                EXPECT_EQ((*beside)[a], face);
                EXPECT_FALSE(at(1.01 * kOutside));
            }
    }
}

TEST(TrilinearCell, OfAFlatOrMirroredCellHasNoInverse) {
    for (const double height : {0.0, 0.9e-9, -1.0}) {
        const TrilinearCell map(
            parallelepiped({0, 0, 0}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, height}}}));
        EXPECT_FALSE(map.locate({0.5, 0.5, 0.5 * height}));
        EXPECT_FALSE(map.locate_from_corners({0.5, 0.5, 0.5 * height}, 1));
    }
    const TrilinearCell thin(parallelepiped({0, 0, 0}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1.1e-9}}}));
    EXPECT_TRUE(thin.locate({0.5, 0.5, 0.5e-9}));
}

TEST(TrilinearCell, FindsAnyPointOfAParallelepipedButNoFarOneOfABentCell) {
    Corners corners = parallelepiped({0, 0, 0}, kIdentity3);
    const auto found = TrilinearCell(corners).locate({40, 0.5, 0.25}, 50);
    ASSERT_TRUE(found);
    EXPECT_EQ(*found, (Vec3d{1, 0.5, 0.25}));
    corners[7] = corners[7] + Vec3d{1e-3, 0, 0};
    EXPECT_TRUE(TrilinearCell(corners).locate({7, 0.5, 0.25}, 50));
    EXPECT_FALSE(TrilinearCell(corners).locate({9, 0.5, 0.25}, 50));
}

TEST(TrilinearCell, FindsMoreFromItsCornersThanFromItsMiddle) {
    int more = 0;
    for (std::uint64_t seed = 1; seed <= 20'000; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TrilinearCell map(random_cell(random, 0.8));
        const Vec3d point = map.at(inner_point(random));
        const auto from_middle = map.locate(point),
                   from_corners = map.locate_from_corners(point, 0);
        if (from_middle) {
            ASSERT_LE(norm(map.at(*from_middle) - point), 1e-6);  // settled, or none
        }
        if (!from_corners) continue;
        EXPECT_LE(norm(map.at(*from_corners) - point), 1e-9);
        more += !from_middle;
    }
    EXPECT_GT(more, 20);
}

TEST(CellPlanes, AreTheFacesOfAParallelepipedAHundredThousandthAside) {
    Random random(3);
    const Mat3d turn = random.rotation(false);
    const Vec3d edge_mm{2, 0.5, 3};
    Mat3d edges;
    for (int a = 0; a < 3; ++a) edges.columns[a] = edge_mm[a] * turn.columns[a];
    const Corners corners = parallelepiped({1, -2, 4}, edges);
    const TrilinearCell map(corners);
    const CellPlanes planes(corners);
    for (int a = 0; a < 3; ++a)
        for (const double face : {0.0, 1.0}) {
            const auto may_hold = [&](double beside) {
                Vec3d t{0.2, 0.5, 0.9};
                t[a] = face + (face == 0 ? -1 : 1) * beside / edge_mm[a];
                return planes.may_hold(map.at(t));
            };
            EXPECT_TRUE(may_hold(0.99e-5));
            EXPECT_FALSE(may_hold(1.01e-5));
        }
}

}  // namespace
}  // namespace pliant::test
