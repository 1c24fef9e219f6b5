// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The bound of a cell's determinant against samples; the inverse against the map.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "morph/node_map.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using morph::least_determinant;
using morph::NodeMap;

std::array<Vec3d, 8> random_cell(Random& random, double size) {
    std::array<Vec3d, 8> corners;
    for (int c = 0; c < 8; ++c)
        corners[std::size_t(c)] =
            Vec3d{double(c & 1), double(c >> 1 & 1), double(c >> 2)} + random.vector(size);
    return corners;
}

/// det ∂φ/∂X at a point of a cell.
double determinant_at(const std::array<Vec3d, 8>& corners, Vec3d t) {
    Mat3d f{};
    for (int a = 0; a < 3; ++a) {
        f.columns[a] = {0, 0, 0};
        for (int c = 0; c < 8; ++c) {
            double weight = c >> a & 1 ? 1 : -1;
            for (int b = 0; b < 3; ++b)
                if (b != a) weight *= c >> b & 1 ? t[b] : 1 - t[b];
            f.columns[a] = f.columns[a] + weight * corners[std::size_t(c)];
        }
    }
    return determinant(f);
}

TEST(NodeMap, The_bound_of_a_cell_is_below_its_determinants_and_meets_those_of_corners) {
    const std::uint64_t seed = std::uint64_t(std::random_device{}());
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    int folded = 0, whole = 0;
    for (int n = 0; n < 300; ++n) {
        const double rough = random.real(0, 1);
        const auto corners = random_cell(random, rough);
        const double bound = least_determinant(corners);
        double at_corners = 1e9, inside = 1e9;
        for (int c = 0; c < 8; ++c)
            at_corners = std::min(
                at_corners,
                determinant_at(corners, {double(c & 1), double(c >> 1 & 1), double(c >> 2)}));
        for (int m = 0; m < 60; ++m)
            inside = std::min(inside, determinant_at(corners, {random.real(0, 1), random.real(0, 1),
                                                               random.real(0, 1)}));
        EXPECT_LE(bound, at_corners + 1e-12);
        EXPECT_LE(bound, inside + 1e-12);
        // A corner's determinant is one of the coefficients, so the bound isn't far off.
        EXPECT_TRUE(rough > 0.2 || bound > std::min(at_corners, inside) - 0.3);
        (bound > 0 ? whole : folded) += 1;
    }
    EXPECT_GT(whole, 50);
    EXPECT_GT(folded, 50);
    std::array<Vec3d, 8> affine = random_cell(random, 0);
    const Mat3d m{{Vec3d{1.2, 0.1, 0}, Vec3d{-0.2, 0.7, 0.3}, Vec3d{0, 0.1, 1.5}}};
    for (Vec3d& p : affine) p = m * p;
    EXPECT_NEAR(least_determinant(affine), determinant(m), 1e-12);
}

Grid oblique(Random& random) {
    return {{9, 7, 8}, {4, 6, 5}, {10, -20, 5}, random.rotation(random.whole(0, 1) == 1)};
}

TEST(NodeMap, The_inverse_of_a_random_map_without_folds_is_exact_in_all_of_space) {
    const std::uint64_t seed = std::uint64_t(std::random_device{}());
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const TaskArena arena(2);
    int used = 0;
    for (int n = 0; n < 40; ++n) {
        const Grid grid = oblique(random);
        const Vec3d shift = random.vector(30);
        const double rough = random.real(0.2, 1.2);
        std::vector<Vec3d> u(voxel_count(grid));
        for (Vec3d& v : u) v = shift + random.vector(rough);
        const NodeMap map(grid, u);
        double least = 0;
        if (!map.cells_below(0.05, least, arena).empty()) continue;
        ++used;
        EXPECT_GE(least, 0.05);
        for (int m = 0; m < 40; ++m) {
            const Vec3d x = world_from_voxel(
                grid, {random.real(-6, 14), random.real(-6, 12), random.real(-6, 13)});
            const Vec3d y = x + map.displacement_mm(x);
            for (const Vec3d guess : {Vec3d{0, 0, 0}, -shift, random.vector(20)})
                EXPECT_LT(norm(map.inverse_mm(y, guess) - x), 1e-5);
        }
    }
    EXPECT_GT(used, 10);
}

TEST(NodeMap, Folded_cells_are_found_within_the_lattice_and_beyond_it) {
    const Grid grid{{6, 6, 6}, {2, 2, 2}, {0, 0, 0}, kIdentity3};
    const TaskArena arena(1);
    std::vector<Vec3d> u(voxel_count(grid), Vec3d{1, 2, 3});
    double least = 0;
    EXPECT_TRUE(NodeMap(grid, u).cells_below(0.05, least, arena).empty());
    EXPECT_NEAR(least, 1, 1e-12);
    u[voxel_index(grid, {2, 3, 3})].x += 3;  // beyond its neighbour
    auto cells = NodeMap(grid, u).cells_below(0.05, least, arena);
    EXPECT_EQ(cells.size(), 4u);
    EXPECT_LT(least, 0);
    for (const auto& cell : cells) EXPECT_EQ(cell.lowest.x, 2);
    u[voxel_index(grid, {2, 3, 3})].x -= 3;
    // Planes that change order at the border: the outside folds with it.
    for (int k = 0; k < 6; ++k)
        for (int j = 0; j < 6; ++j) u[voxel_index(grid, {5, j, k})].x -= 3;
    cells = NodeMap(grid, u).cells_below(0.05, least, arena);
    EXPECT_EQ(cells.size(), 49u);
}

TEST(NodeMap, Displacements_are_trilinear_and_constant_beyond) {
    Random random(3);
    const Grid grid = oblique(random);
    std::vector<Vec3d> u(voxel_count(grid));
    for (Vec3d& v : u) v = random.vector(5);
    const NodeMap map(grid, u);
    const auto node = [&](Vec3i p) { return u[voxel_index(grid, p)]; };
    const auto at = [&](Vec3d ijk) { return map.displacement_mm(world_from_voxel(grid, ijk)); };
    EXPECT_LT(norm(at({3, 4, 5}) - node({3, 4, 5})), 1e-12);
    EXPECT_LT(norm(at({3.25, 4, 5}) - 0.75 * node({3, 4, 5}) - 0.25 * node({4, 4, 5})), 1e-12);
    EXPECT_LT(norm(at({-8, 4, 5}) - node({0, 4, 5})), 1e-12);
    EXPECT_LT(norm(at({3, 20, 70}) - node({3, 6, 7})), 1e-12);
}

}  // namespace
}  // namespace pliant::test
