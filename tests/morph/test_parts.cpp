// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parts of analytic shapes.
// Covers: morph/parts.cpp, morph/mask_depth.cpp, morph/slide.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>

#include "morph/mask_depth.h"
#include "morph/parts.h"
#include "morph/shapes.h"
#include "morph/slide.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using morph::Mask;
using morph::Part;

Mask mask_of(const Volume& volume) {
    Mask mask{volume.grid, {}};
    for (int k = 0; k < volume.grid.size.z; ++k)
        for (int j = 0; j < volume.grid.size.y; ++j)
            for (int i = 0; i < volume.grid.size.x; ++i)
                mask.in.push_back(volume.at({i, j, k}) > 0);
    return mask;
}

TEST(Parts, Depth_is_the_distance_to_the_nearest_voxel_outside) {
    const std::uint64_t seed = std::uint64_t(std::random_device{}());
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const Grid grid{{9, 8, 7}, {1, 2, 1.5}, {0, 0, 0}, kIdentity3};
    const Mask mask = mask_of(shape(grid, [&](Vec3d) { return random.whole(0, 9) > 0; }));
    const auto depth = morph::depth_mm(mask);
    for (std::size_t n = 0; n < depth.size(); ++n) {
        double least = 1e9;
        const auto at = [&](std::size_t m) {
            return world_from_voxel(grid, {double(m % 9), double(m / 9 % 8), double(m / 72)});
        };
        for (std::size_t m = 0; m < depth.size(); ++m)
            if (!mask.in[m]) least = std::min(least, norm(at(m) - at(n)));
        EXPECT_NEAR(depth[n], least, 1e-5);
    }
}

TEST(Parts, Two_balls_that_touch_are_separated_and_one_is_not) {
    const Grid grid = cube_grid();
    const Mask two = mask_of(shape(grid, [](Vec3d x) {
        return in_ellipsoid(x, {-30, 0, 0}, {32, 40, 50}) ||
               in_ellipsoid(x, {32, 5, 0}, {32, 35, 50});
    }));
    const auto halves = morph::split(two);
    ASSERT_EQ(halves.size(), 2u);
    std::size_t total = 0;
    for (std::size_t half = 0; half < 2; ++half)
        for (std::size_t n = 0; n < halves[half].in.size(); ++n) {
            if (!halves[half].in[n]) continue;
            ++total;
            const Vec3i size = halves[half].grid.size;
            const auto m = int(n);
            const Vec3d x = world_from_voxel(
                halves[half].grid,
                {double(m % size.x), double(m / size.x % size.y), double(m / (size.x * size.y))});
            EXPECT_TRUE(std::abs(x.x) <= 6 || (x.x > 0) == (half == 1));
            EXPECT_FALSE(halves[0].in[n] && halves[1].in[n]);
        }
    EXPECT_EQ(total, std::size_t(std::count(two.in.begin(), two.in.end(), 1)));
    const Mask one = mask_of(shape(grid, [](Vec3d x) {
        return in_ellipsoid(x, {0, 0, 0}, {60, 40, 50});
    }));
    EXPECT_EQ(morph::split(one).size(), 1u);
}

TEST(Parts, The_surface_of_an_ellipsoid_has_its_points_and_normals) {
    Random random(4);
    Grid grid = cube_grid();
    grid.direction = random.rotation(true);
    grid.origin_mm = grid.direction * grid.origin_mm;
    const Vec3d radii{60, 40, 50};
    const auto surface = morph::surface_of(mask_of(shape(grid, [&](Vec3d x) {
        return in_ellipsoid(x, {0, 0, 0}, radii);
    })));
    EXPECT_GT(surface.points.size(), 4000u);
    double bias = 0;
    for (std::size_t n = 0; n < surface.points.size(); ++n) {
        const Vec3d x = surface.points[n];
        const Vec3d slope{x.x / (60 * 60), x.y / (40 * 40), x.z / (50 * 50)};
        const double off = (dot(x, slope) - 1) / (2 * norm(slope));  // [mm], to first order
        EXPECT_LT(std::abs(off), 1.3);
        bias += off / double(surface.points.size());
        EXPECT_GT(dot(surface.normals[n], normalized(slope)), 0.97);
    }
    EXPECT_LT(std::abs(bias), 0.3);
}

TEST(Parts, Thinning_leaves_a_point_in_each_cell) {
    Random random(5);
    std::vector<Vec3d> points;
    for (int n = 0; n < 4000; ++n) points.push_back(normalized(random.vector(1)));
    for (Vec3d& p : points) p = 50.0 * p;
    const auto chosen = morph::thinned(points, 160);
    EXPECT_GT(chosen.size(), 110u);
    EXPECT_LE(chosen.size(), 160u);
    EXPECT_EQ(std::set<std::size_t>(chosen.begin(), chosen.end()).size(), chosen.size());
    for (const Vec3d& p : points) {
        double near = 1e9;
        for (const std::size_t n : chosen) near = std::min(near, norm(points[n] - p));
        EXPECT_LT(near, 35);
    }
}

/// Two lungs with a heart between them at small or large y.
Volume lungs(double front, double size) {
    const Grid grid{{120, 90, 100}, {2.5, 2.5, 2.5}, {-150, -112, -125}, kIdentity3};
    return shape(grid, [&](Vec3d x) {
        const bool heart = in_ellipsoid(x, {0, front * 50, -20}, {55, 55, 60});
        return !heart && (in_ellipsoid(x, {-62, 0, 0}, size * Vec3d{55, 90, 110}) ||
                          in_ellipsoid(x, {62, 0, 0}, size * Vec3d{55, 90, 110}));
    });
}

TEST(Parts, The_heart_shows_the_front_of_lungs) {
    const TaskArena arena(2);
    for (const double front : {-1.0, 1.0}) {
        const auto parts = morph::find_parts(lungs(front, 1), lungs(front, 1.05), {}, arena);
        ASSERT_TRUE(parts.ok());
        EXPECT_TRUE(parts->are_lungs);
        EXPECT_EQ(parts->back, -front);
        ASSERT_EQ(parts->list.size(), 2u);
        EXPECT_GT(parts->list[0].volume_to_mm3, parts->list[0].volume_from_mm3);
    }
    const Grid grid = cube_grid();
    const Volume balls = shape(grid, [](Vec3d x) {
        return in_ellipsoid(x, {-40, 0, 0}, {30, 40, 50}) ||
               in_ellipsoid(x, {40, 0, 0}, {30, 40, 50});
    });
    const auto parts = morph::find_parts(balls, balls, {}, arena);
    ASSERT_TRUE(parts.ok());
    EXPECT_EQ(parts->list.size(), 2u);
    EXPECT_FALSE(parts->are_lungs);
}

TEST(Parts, Labels_of_both_maps_are_parts) {
    const Grid grid = cube_grid();
    Volume from = shape(grid, [](Vec3d x) { return in_ellipsoid(x, {0, 0, 0}, {60, 40, 50}); });
    Volume to = from;
    auto& voxels = std::get<0>(from.voxels);
    for (std::size_t n = 0; n < voxels.size() / 2; ++n) voxels[n] = std::int16_t(7 * voxels[n]);
    const TaskArena arena(1);
    auto parts = morph::find_parts(from, to, {}, arena);
    ASSERT_TRUE(parts.ok());
    EXPECT_EQ(parts->list.size(), 1u);  // label 1 alone
    parts = morph::find_parts(from, from, {}, arena);
    ASSERT_TRUE(parts.ok());
    EXPECT_EQ(parts->list.size(), 2u);
    const Volume empty = shape(grid, [](Vec3d) { return false; });
    parts = morph::find_parts(from, empty, {}, arena);
    ASSERT_FALSE(parts.ok());
    EXPECT_EQ(parts.error().message, "to: expected a label of from (1, 7), found none");
}

TEST(Parts, Labels_with_a_modulus_belong_to_the_part_around_them) {
    const TaskArena arena(2);
    const Grid grid = cube_grid();
    Volume from = shape(grid, [](Vec3d x) { return in_ellipsoid(x, {0, 0, 0}, {60, 40, 50}); });
    const Volume to = from;
    auto& voxels = *std::get_if<0>(&from.voxels);
    const auto is_stiff = [](Vec3d x) { return in_ellipsoid(x, {20, 5, 0}, {15, 15, 15}); };
    const Volume stiff = shape(grid, is_stiff);
    for (std::size_t n = 0; n < voxels.size(); ++n)
        if ((*std::get_if<0>(&stiff.voxels))[n]) voxels[n] = 7;
    voxels[0] = 7;  // which no part reaches
    const MorphModulus moduli[] = {{7, 30}};
    const auto parts = morph::find_parts(from, to, moduli, arena);
    ASSERT_TRUE(parts.ok());
    ASSERT_EQ(parts->list.size(), 1u);
    const Part& part = parts->list[0];
    EXPECT_EQ(part.voxels_from.size(), part.voxels_to.size());
    ASSERT_EQ(part.moduli.size(), part.voxels_from.size());
    for (std::size_t n = 0; n < part.moduli.size(); ++n)
        EXPECT_EQ(part.moduli[n], is_stiff(part.voxels_from[n]) ? 30 : 1);
    EXPECT_EQ(morph::find_parts(to, to, moduli, arena).error().message,
              "moduli: expected labels of from (1), found 7");
    const MorphModulus liquid[] = {{7, 0}};
    EXPECT_EQ(morph::find_parts(from, to, liquid, arena).error().message,
              "moduli: expected 0.001 to 1000 of label 7, found 0");
    const MorphModulus twice[] = {{7, 2}, {7, 3}};
    EXPECT_EQ(morph::find_parts(from, to, twice, arena).error().message,
              "moduli: expected one modulus of each label, found two of label 7");
}

TEST(Slide, Gaps_of_a_moved_ball_are_its_shift_along_the_normals) {
    const Grid grid = cube_grid();
    const Vec3d shift{6, -3, 4};
    const auto ball = [&](Vec3d c) {
        return shape(grid, [=](Vec3d x) { return in_ellipsoid(x, c, {45, 45, 45}); });
    };
    const auto parts = morph::find_parts(ball({0, 0, 0}), ball(shift), {}, TaskArena(1));
    ASSERT_TRUE(parts.ok());
    const Part& part = parts->list.at(0);
    morph::Moved moved{part.from.points, part.from.normals};
    for (Vec3d& p : moved.points) p = p + shift;
    double off = 0;
    const auto slides = morph::slides_of(part, moved);
    EXPECT_GT(slides.size(), 2 * part.from.points.size() - 60);
    for (const auto& slide : slides)
        off += std::abs(slide.gap - dot(slide.normal, shift)) / double(slides.size());
    EXPECT_LT(off, 0.5);
    EXPECT_LT(morph::surface_residual_mm(part, moved), 0.5);
    moved = {part.from.points, part.from.normals};
    EXPECT_GT(morph::surface_residual_mm(part, moved), 2.5);
}

TEST(Slide, Normals_move_with_the_surface) {
    // A shear x += y turns the normal of the plane x = 0 towards −y.
    Mat3d shear{};
    shear.columns[1] = {1, 0, 0};
    const Vec3d n = morph::moved_normal(shear, {1, 0, 0});
    EXPECT_LT(norm(n - std::sqrt(0.5) * Vec3d{1, -1, 0}), 1e-12);
    Mat3d flat{};
    flat.columns[0] = {-1, 0, 0};
    EXPECT_EQ(morph::moved_normal(flat, {1, 0, 0}), (Vec3d{1, 0, 0}));
}

}  // namespace
}  // namespace pliant::test
