// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// φ and its inverse against a root search by bisection, on random deformations with folds, cuts and
// void elements.

#include <gtest/gtest.h>

#include <random>

#include "support/random.h"
#include "truth/exact_map.h"
#include "truth/oracle.h"

namespace pliant::test {
namespace {

using truth::CellState;
using truth::ExactMap;

struct Tangle {
    Grid grid;
    Deformation deformation;
};

/// A random deformation of a small grid. @param steep  displacement of neighbours [voxels]
Tangle tangle(Random& random, double steep, bool with_cuts) {
    Grid grid{{9, 8, 7}, {0.7, 1.1, 1.6}, {3, -2, 5}, random.rotation(random.whole(0, 1) == 1)};
    Deformation d = Deformation::create(grid).value();
    const Vec3d push = random.vector(1.5);
    EXPECT_TRUE(d.displace({{1, 1, 1}, {8, 7, 6}}, [&](Vec3i e) {
                     const Vec3d noise = random.vector(steep);
                     const double w = e.x > 3 ? 1 : 0.4;
                     Vec3d u = w * push + noise;
                     for (int a = 0; a < 3; ++a) u[a] *= grid.spacing_mm[a];
                     return world_from_lattice_vector(grid, u);
                 }).ok());
    if (with_cuts) {
        const Box3i plane{{3, 1, 1}, {4, 7, 6}};
        std::vector<std::uint8_t> edits(30, kCutX);
        edits[std::size_t(random.whole(0, 29))] |= kVoid;
        EXPECT_TRUE(d.edit(plane, edits).ok());
    }
    return {grid, std::move(d)};
}

const Box3i kAllCells{{-3, -3, -3}, {12, 11, 10}};

TEST(ExactMap, Finds_the_one_source_of_a_point_or_says_that_there_is_none) {
    const std::uint64_t seed = std::uint64_t(std::random_device{}());
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const TaskArena arena(2);
    int exact = 0, gaps = 0, ambiguous = 0;
    for (int n = 0; n < 24; ++n) {
        const Tangle t = tangle(random, n % 3 == 0 ? 0.05 : n % 3 == 1 ? 0.25 : 0.6, n % 2 == 1);
        const ExactMap map(t.deformation, arena);
        for (int point = 0; point < 60; ++point) {
            Vec3d y{random.real(0, 8), random.real(0, 7), random.real(0, 6)};
            if (point % 2)
                y = {double(random.whole(0, 8)), double(random.whole(0, 7)),
                     double(random.whole(0, 6))};
            const std::vector<Vec3d> expected = sources_by_bisection(t.deformation, kAllCells, y);
            Vec3d x{0, 0, 0};
            const TruthMask mask = map.source_of(y, y, x);
            if (mask == TruthMask::Exact) {
                ASSERT_EQ(expected.size(), 1U) << y.x << " " << y.y << " " << y.z;
                EXPECT_LT(norm(expected[0] - x), 1e-5);
                ++exact;
            } else if (mask == TruthMask::Gap) {
                EXPECT_EQ(expected.size(), 0U);
                ++gaps;
            } else {
                ++ambiguous;
                // Without folded cells, ambiguous means that there are several.
                if (map.folded_cells() == 0) {
                    EXPECT_GT(expected.size(), 1U);
                }
            }
        }
    }
    EXPECT_GT(exact, 300);
    EXPECT_GT(gaps, 5);
    EXPECT_GT(ambiguous, 20);
}

TEST(ExactMap, Maps_points_like_the_trilinear_cells) {
    const std::uint64_t seed = std::uint64_t(std::random_device{}());
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const TaskArena arena(1);
    const Tangle t = tangle(random, 0.3, true);
    const ExactMap map(t.deformation, arena);
    int broken = 0;
    for (int n = 0; n < 500; ++n) {
        const Vec3d x{random.real(-1, 9), random.real(-1, 8), random.real(-1, 7)};
        const Vec3i cell{int(std::floor(x.x)), int(std::floor(x.y)), int(std::floor(x.z))};
        const auto y = map.image_of(x);
        if (!is_whole(t.deformation, cell)) {
            EXPECT_FALSE(y);
            ++broken;
            continue;
        }
        ASSERT_TRUE(y);
        const Vec3d local = x - Vec3d{double(cell.x), double(cell.y), double(cell.z)};
        EXPECT_LT(norm(*y - trilinear(cell_corners(t.deformation, cell), local)), 1e-9);
    }
    EXPECT_GT(broken, 10);
}

TEST(ExactMap, A_regular_cell_is_folded_nowhere) {
    const std::uint64_t seed = std::uint64_t(std::random_device{}());
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    int regular = 0, folded = 0;
    for (int n = 0; n < 3000; ++n) {
        std::array<Vec3d, 8> corners;
        const double steep = random.real(0, 0.8);
        for (int c = 0; c < 8; ++c)
            corners[std::size_t(c)] =
                Vec3d{double(c & 1), double(c >> 1 & 1), double(c >> 2)} + random.vector(steep);
        const CellState state = truth::state_of_shape(corners);
        double least = 1e9;
        for (int point = 0; point < 200; ++point) {
            Vec3d t{random.real(0, 1), random.real(0, 1), random.real(0, 1)};
            if (point < 8) t = {double(point & 1), double(point >> 1 & 1), double(point >> 2)};
            const double h = 1e-5;
            Mat3d f;
            for (int a = 0; a < 3; ++a) {
                Vec3d step{0, 0, 0};
                step[a] = h;
                f.columns[a] =
                    (1 / (2 * h)) * (trilinear(corners, t + step) - trilinear(corners, t - step));
            }
            least = std::min(least, determinant(f));
        }
        if (state == CellState::Regular) {
            EXPECT_GT(least, -1e-9);
            ++regular;
        } else {
            ++folded;
        }
        if (least < 0) {
            EXPECT_EQ(state, CellState::Folded);
        }
    }
    EXPECT_GT(regular, 200);
    EXPECT_GT(folded, 200);
}

TEST(ExactMap, Is_the_identity_at_rest) {
    const Deformation rest = Deformation::create({{9, 8, 7}}).value();
    const TaskArena arena(1);
    const ExactMap map(rest, arena);
    Vec3d x{0, 0, 0};
    EXPECT_EQ(map.source_of({1.25, 2, 3}, {0, 0, 0}, x), TruthMask::Exact);
    EXPECT_EQ(x, (Vec3d{1.25, 2, 3}));
    EXPECT_EQ(map.image_of(Vec3d{1.25, 2, 3}), (Vec3d{1.25, 2, 3}));
}

}  // namespace
}  // namespace pliant::test
