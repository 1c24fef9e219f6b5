// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Small parts of the resampler separately: the planes that reject points, and the list of open
// boxes. Each may be too large, but must not miss anything.
// Covers: field/trilinear_cell.h, resample/open_voxels.cpp, resample/strip_*.cpp.

#include <gtest/gtest.h>

#include "field/trilinear_cell.h"
#include "resample/open_voxels.h"
#include "support/random.h"

namespace pliant::test {
namespace {

std::array<Vec3d, 8> random_cell(Random& random) {
    Mat3d columns;
    for (auto& column : columns.columns) column = random.vector(1);
    const double bend = random.real(0, 0.5);
    std::array<Vec3d, 8> corners;
    for (int c = 0; c < 8; ++c)
        corners[std::size_t(c)] =
            columns * Vec3d{double(c & 1), double(c >> 1 & 1), double(c >> 2)} +
            random.vector(bend);
    return corners;
}

TEST(CellPlanes, HoldEveryPointOfTheCellAndSeeOffMostOthers) {
    int others = 0, seen_off = 0;
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const std::array<Vec3d, 8> corners = random_cell(random);
        const CellPlanes planes(corners);
        const TrilinearCell map(corners);
        for (int n = 0; n < 100; ++n) {
            // On faces, edges and corners too.
            Vec3d t;
            for (int a = 0; a < 3; ++a) {
                const int where = random.whole(0, 4);
                t[a] = where == 0 ? 0 : where == 1 ? 1 : random.real(0, 1);
            }
            ASSERT_TRUE(planes.may_hold(map.at(t)));
        }
        for (int n = 0; n < 20; ++n) {
            const Vec3d point = map.at({0.5, 0.5, 0.5}) + random.vector(6);
            if (map.locate(point)) continue;
            ++others;
            seen_off += !planes.may_hold(point);
        }
    }
    EXPECT_GT(seen_off, others * 3 / 4);
}

TEST(OpenBoxes, GiveBackExactlyWhatIsOpenWithinABox) {
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const int size = random.whole(3, 9);
        const Vec3i bricks{random.whole(1, 5), random.whole(1, 5), random.whole(1, 5)};
        OpenBoxes open;
        // The second list must not contain parts of the first.
        for (int round = 0; round < 2; ++round) {
            std::vector<DirtyBrick> dirty;
            for_each_in({{0, 0, 0}, bricks}, [&](Vec3i coord) {
                if (random.whole(0, 2) == 0) return;
                DirtyBrick brick{.coord = coord};
                for (int a = 0; a < 3; ++a) {
                    brick.open.begin[a] = size * coord[a] + random.whole(0, size - 1);
                    brick.open.end[a] =
                        random.whole(brick.open.begin[a], size * (coord[a] + 1));  // may be empty
                }
                dirty.push_back(brick);
            });
            const bool any = open.list(dirty, bricks, size);
            bool expected_any = false;
            for (const DirtyBrick& brick : dirty) expected_any |= !is_empty(brick.open);
            EXPECT_EQ(any, expected_any);
            Box3i voxels;
            for (int a = 0; a < 3; ++a) {
                voxels.begin[a] = random.whole(0, size * bricks[a] - 1);
                voxels.end[a] = random.whole(voxels.begin[a] + 1, size * bricks[a]);
            }
            std::vector<Box3i> parts{voxels};  // is replaced
            open.within(voxels, parts);
            const auto holds = [](const auto& boxes, Vec3i p) {
                return std::count_if(boxes.begin(), boxes.end(),
                                     [&](const Box3i& box) { return contains(box, p); });
            };
            std::vector<Box3i> all;
            for (const DirtyBrick& brick : dirty) all.push_back(brick.open);
            for_each_in({{0, 0, 0}, {size * bricks.x, size * bricks.y, size * bricks.z}},
                        [&](Vec3i p) {
                            ASSERT_EQ(holds(parts, p), contains(voxels, p) ? holds(all, p) : 0);
                        });
        }
    }
}

}  // namespace
}  // namespace pliant::test
