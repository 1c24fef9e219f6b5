// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The triangles near a segment or box, against brute force.
// Covers: pbd/tool_contact.cpp, pbd/triangle_grid.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pbd/segment_triangle.h"
#include "pbd/triangle_grid.h"
#include "support/random.h"

namespace pliant::test {
namespace {

// The distance from a triangle is convex along the segment, so that golden sections find the least.
TEST(SegmentAndTriangle, NearestPairsAreThoseOfASearchAlongTheSegment) {
    int through = 0, between = 0;
    for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const Vec3d p = random.vector(2), q = random.vector(2);
        const Vec3d a = random.vector(1), b = random.vector(1), c = random.vector(1);
        const auto at = [&](double s) {
            const Vec3d x = (1 - s) * p + s * q;
            return norm(x - mesh::nearest_on_triangle(x, a, b, c).position);
        };
        double low = 0, high = 1;
        const double golden = (std::sqrt(5.0) - 1) / 2;
        for (int n = 0; n < 80; ++n) {
            const double u = high - golden * (high - low), v = low + golden * (high - low);
            (at(u) < at(v) ? high : low) = at(u) < at(v) ? v : u;
        }
        const double least = std::min({at(0), at(1), at(0.5 * (low + high))});
        const pbd::NearestPair pair = pbd::nearest_pair(p, q, a, b, c);
        EXPECT_NEAR(std::sqrt(pbd::distance2(pair)), least, 1e-7);
        EXPECT_LT(norm(pair.on_segment - ((1 - pair.along) * p + pair.along * q)), 1e-12);
        const Vec3d on = mesh::nearest_on_triangle(pair.on_triangle, a, b, c).position;
        EXPECT_LT(norm(on - pair.on_triangle), 1e-7);
        through += least < 1e-9;
        between += pair.along > 0 && pair.along < 1 && pair.feature < 6;
    }
    EXPECT_GT(through, 50);
    EXPECT_GT(between, 500);
}

TEST(TriangleGrid, FindsAllThatBruteForceFinds) {
    pbd::TriangleGrid grid;
    std::int64_t found_all = 0, asked = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        std::vector<Vec3d> positions;
        std::vector<std::array<std::int32_t, 3>> triangles;
        const int count = random.whole(1, 400);
        for (int t = 0; t < count; ++t) {
            const Vec3d middle = random.vector(10);
            for (int k = 0; k < 3; ++k) positions.push_back(middle + random.vector(1));
            triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
        }
        const double margin = 0.1;
        grid.fill(positions, triangles, margin);
        std::vector<std::int32_t> found;
        for (int question = 0; question < 30; ++question) {
            const Vec3d middle = random.vector(12), half{random.real(0, 3), 1, 0.5};
            grid.near(middle - half, middle + half, found);
            EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
            EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
            for (int t = 0; t < count; ++t) {
                bool meets = true;
                for (int c = 0; c < 3; ++c) {
                    const auto at = [&](int k) { return positions[std::size_t(3 * t + k)][c]; };
                    meets &= std::max({at(0), at(1), at(2)}) + margin >= middle[c] - half[c];
                    meets &= std::min({at(0), at(1), at(2)}) - margin <= middle[c] + half[c];
                }
                if (meets) {
                    EXPECT_TRUE(std::binary_search(found.begin(), found.end(), t));
                }
            }
            found_all += std::int64_t(found.size());
            asked += count;
        }
    }
    EXPECT_LT(found_all, asked / 4);
}

}  // namespace
}  // namespace pliant::test
