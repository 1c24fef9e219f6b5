// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A caster with a changing volume, picking, and the surface point nearest to a point.
// Covers: render/bricks.cpp, render/nearest_surface.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/analytic_volumes.h"
#include "render/bricks.h"

namespace pliant {
namespace {

using test::centre_mm;
using test::make_volume;
using test::odd_grid;
using test::plain_grid;
using test::random_unit;

template <class T>
bool are_equal(const render::BrickLevel<T>& a, const render::BrickLevel<T>& b) {
    for (std::size_t n = 0; n < a.ranges.size(); ++n)
        if (a.ranges[n].min != b.ranges[n].min || a.ranges[n].max != b.ranges[n].max) return false;
    return a.ranges.size() == b.ranges.size();
}

TEST(Bricks, AreUpdatedToWhatTheyWouldBeIfMadeAnew) {
    std::mt19937 random(51);
    TaskArena arena(2);
    for (const Vec3i size : {Vec3i{71, 20, 9}, Vec3i{130, 17, 66}, Vec3i{2, 2, 2}}) {
        const Grid grid = plain_grid(size);
        std::vector<std::int16_t> voxels(voxel_count(grid));
        for (auto& v : voxels) v = std::int16_t(random() % 100);
        const render::VoxelField<std::int16_t> field(voxels.data(), size);
        auto bricks = render::make_bricks(field, arena);
        std::vector<std::int32_t> scratch;
        for (int round = 0; round < 30; ++round) {
            std::vector<Box3i> boxes(random() % 4);
            for (Box3i& box : boxes) {
                for (int a = 0; a < 3; ++a) {
                    box.begin[a] = int(random() % unsigned(size[a]));
                    box.end[a] = std::min(size[a], box.begin[a] + int(random() % 12));
                }
                for (int z = box.begin.z; z < box.end.z; ++z)
                    for (int y = box.begin.y; y < box.end.y; ++y)
                        for (int x = box.begin.x; x < box.end.x; ++x)
                            voxels[voxel_index(grid, {x, y, z})] =
                                std::int16_t(int(random() % 3000) - 1500);
            }
            render::update_bricks(bricks, field, boxes, scratch, arena);
            const auto anew = render::make_bricks(field, arena);
            ASSERT_TRUE(are_equal(bricks.fine, anew.fine)) << "seed 51 round " << round;
            ASSERT_TRUE(are_equal(bricks.coarse, anew.coarse)) << "seed 51 round " << round;
        }
    }
}

TEST(RayCaster, SeesWhatHasChangedAfterAnUpdate) {
    const Grid grid = plain_grid({64, 64, 64});
    Volume volume = make_volume<std::int16_t>(grid, [](Vec3d) { return -1000; });
    TaskArena arena(1);
    RayCaster caster(volume, arena);
    EXPECT_FALSE(caster.first_hit({5, 32, 32}, {1, 0, 0}, -500, Polarity::Rising));
    auto& voxels = *std::get_if<0>(&volume.voxels);
    const Box3i box{{40, 30, 30}, {43, 35, 35}};
    for (int z = 30; z < 35; ++z)
        for (int y = 30; y < 35; ++y)
            for (int x = 40; x < 43; ++x) voxels[voxel_index(grid, {x, y, z})] = 0;
    caster.update({&box, 1});
    const auto hit = caster.first_hit({5, 32, 32}, {1, 0, 0}, -500, Polarity::Rising);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance_mm, 34.5, 1e-9);
    const std::vector<Vec3d> rays = {{1, 0.001, 0.001}};
    std::vector<double> distances(1);
    caster.first_hits({5, 32, 32}, rays, -500, Polarity::Rising, distances);
    EXPECT_NEAR(distances[0], 34.5, 1e-9);
}

TEST(RayCaster, PicksWhatThePixelShows) {
    const Grid grid = odd_grid({50, 50, 50});
    const Vec3d centre = centre_mm(grid);
    const auto volume =
        make_volume<float>(grid, [&](Vec3d p) { return 100 * (norm(p - centre) - 15); });
    TaskArena arena(1);
    const RayCaster caster(volume, arena);
    Endoscope e;
    e.eye_mm = centre;
    e.look = {0.3, 1, -0.2};
    e.iso_hu = 0;
    const auto middle = caster.pick(e, 200, 100, 100, 50);
    ASSERT_TRUE(middle);
    EXPECT_GT(dot(normalized(middle->point_mm - centre), normalized(e.look)), 1 - 1e-9);
    const auto left = caster.pick(e, 200, 100, 20, 50), right = caster.pick(e, 200, 100, 180, 50);
    ASSERT_TRUE(left && right);
    EXPECT_NEAR(left->distance_mm, right->distance_mm, 0.2);
    EXPECT_LT(dot(normalized(left->point_mm - centre), normalized(right->point_mm - centre)), 0.7);
}

TEST(RayCaster, FindsTheNearestPlaceOnASphereAndAPlane) {
    const Grid grid = odd_grid({60, 50, 40});
    const Vec3d centre = centre_mm(grid), n = normalized({0.3, -0.8, 0.5});
    TaskArena arena(1);
    const auto sphere =
        make_volume<float>(grid, [&](Vec3d p) { return 100 * (norm(p - centre) - 14); });
    const auto plane = make_volume<float>(grid, [&](Vec3d p) { return 64 * dot(p - centre, n); });
    const RayCaster in_sphere(sphere, arena), at_plane(plane, arena);
    std::mt19937 random(52);
    for (int i = 0; i < 60; ++i) {
        const Vec3d d = random_unit(random);
        const double r = 4 + i % 16;  // the surface is 0…10 mm away, on either side
        const Vec3d p = centre + r * d;
        const auto found = in_sphere.nearest_surface(p, 11, 0);
        ASSERT_TRUE(found) << "seed 52 " << i;
        EXPECT_NEAR(found->distance_mm, std::abs(r - 14), 0.2);
        EXPECT_LT(norm(found->point_mm - (centre + 14.0 * d)), 3);
        EXPECT_GT(dot(found->normal, -normalized(found->point_mm - centre)), 0.99);
        // A sphere touches just if the surface is within its radius.
        const double doubt = 0.02 + 0.01 * found->distance_mm;
        EXPECT_TRUE(in_sphere.nearest_surface(p, found->distance_mm + doubt, 0));
        EXPECT_FALSE(in_sphere.nearest_surface(p, found->distance_mm - doubt, 0));
        const Vec3d q = centre + 5.0 * random_unit(random);
        const auto foot = at_plane.nearest_surface(q, 6, 0);
        ASSERT_TRUE(foot);
        EXPECT_NEAR(foot->distance_mm, std::abs(dot(q - centre, n)), 0.06);
    }
    EXPECT_FALSE(in_sphere.nearest_surface({std::nan(""), 0, 0}, 5, 0));
    EXPECT_FALSE(in_sphere.nearest_surface(centre, -1, 0));
}

TEST(RayCaster, FindsTheNearestPlaceOfASurfaceInNoise) {
    // Against all points where fine steps along many rays cross the surface.
    std::mt19937 random(53);
    std::uniform_real_distribution<double> value(-1000, 1000);
    const Grid grid = plain_grid({10, 10, 10});
    const auto volume = make_volume<std::int16_t>(grid, [&](Vec3d) { return value(random); });
    TaskArena arena(1);
    const RayCaster caster(volume, arena);
    for (int i = 0; i < 20; ++i) {
        const Vec3d p{3 + 0.1 * i, 4.4, 5.1};
        const auto found = caster.nearest_surface(p, 4, 700);
        ASSERT_TRUE(found);
        double nearest = 1e9;
        for (int k = 0; k < 4000; ++k) {
            const Vec3d d = random_unit(random);
            for (const Polarity polarity : {Polarity::Rising, Polarity::Falling})
                if (const auto hit = caster.first_hit(p, d, 700, polarity))
                    nearest = std::min(nearest, hit->distance_mm);
        }
        EXPECT_LE(found->distance_mm, nearest + 0.04) << "seed 53 " << i;
        EXPECT_GE(found->distance_mm, nearest - 0.15) << "seed 53 " << i;
        EXPECT_NEAR(sample_linear(volume, found->point_mm), 700, 60) << "seed 53 " << i;
    }
}

}  // namespace
}  // namespace pliant
