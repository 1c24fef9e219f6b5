// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

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

/// Trilinear value by the textbook, nothing shared with the caster. NaN beyond the voxel centres.
double trilinear(const Volume& v, Vec3d x_mm) {
    const Vec3d p = voxel_from_world(v.grid, x_mm);
    double sum = 0;
    for (int a = 0; a < 3; ++a)
        if (!(p[a] >= 0 && p[a] <= v.grid.size[a] - 1)) return std::nan("");
    const Vec3i c{int(std::min(p.x, v.grid.size.x - 2.0)), int(std::min(p.y, v.grid.size.y - 2.0)),
                  int(std::min(p.z, v.grid.size.z - 2.0))};
    for (int k = 0; k < 8; ++k) {
        const Vec3i q{c.x + (k & 1), c.y + (k >> 1 & 1), c.z + (k >> 2)};
        sum += double(v.at(q)) * (1 - std::abs(p.x - q.x)) * (1 - std::abs(p.y - q.y)) *
               (1 - std::abs(p.z - q.z));
    }
    return sum;
}

/// Marches in small steps. @returns where the wanted turn is, or −1
double march(const Volume& v, Vec3d origin, Vec3d unit, double iso, bool rising, double step) {
    double before = std::nan("");
    for (double t = 0; t < 400; t += step) {
        const double now = trilinear(v, origin + t * unit);
        const bool known = !std::isnan(before) && !std::isnan(now);
        if (known && rising && before < iso && now >= iso) return t;
        if (known && !rising && before >= iso && now < iso) return t;
        before = now;
    }
    return -1;
}

TEST(RayCaster, MeetsASphereWhereItIs) {
    // The distance from the centre, seen from inside: trilinear interpolation of a convex function
    // lies above it by at most |h|²/8 of its curvature.
    const Grid grid = odd_grid({70, 60, 50});
    const Vec3d centre = centre_mm(grid);
    const auto volume =
        make_volume<float>(grid, [&](Vec3d p) { return 100 * (norm(p - centre) - 20); });
    TaskArena arena(2);
    const RayCaster caster(volume, arena);
    std::mt19937 random(7);
    for (int i = 0; i < 500; ++i) {
        const Vec3d d = random_unit(random);
        const auto hit = caster.first_hit(centre, 3.0 * d, 0, Polarity::Rising);
        ASSERT_TRUE(hit) << "ray " << i << " of seed 7";
        EXPECT_NEAR(hit->distance_mm, 20, 0.06);
        EXPECT_LT(norm(hit->point_mm - (centre + hit->distance_mm * d)), 1e-9);
        EXPECT_NEAR(norm(hit->normal), 1, 1e-9);
        EXPECT_GT(dot(hit->normal, -d), 0.998);
    }
}

TEST(RayCaster, MeetsAPlaneExactlyFromInsideAndOutside) {
    // A linear field is its own trilinear interpolant, so the answer is exact.
    const Grid grid = odd_grid({40, 33, 29});
    const Vec3d centre = centre_mm(grid), n = normalized({0.3, -0.8, 0.5});
    const auto volume =
        make_volume<float>(grid, [&](Vec3d p) { return float(64 * dot(p - centre, n)); });
    TaskArena arena(2);
    const RayCaster caster(volume, arena);
    std::mt19937 random(11);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3d target = centre + 6.0 * cross(n, random_unit(random));
        const Vec3d d = random_unit(random);
        if (dot(d, n) < 0.2) continue;
        const double far = i % 2 == 0 ? 3 : 300;
        const auto hit = caster.first_hit(target - far * d, d, 0, Polarity::Rising);
        ASSERT_TRUE(hit) << "ray " << i << " of seed 11";
        EXPECT_NEAR(hit->distance_mm, far, 2e-4);  // voxels are float
        EXPECT_GT(dot(hit->normal, -n), 1 - 1e-5);
        EXPECT_FALSE(caster.first_hit(target - far * d, d, 0, Polarity::Falling));
        const auto back = caster.first_hit(target + far * d, -d, 0, Polarity::Falling);
        ASSERT_TRUE(back);
        EXPECT_NEAR(back->distance_mm, far, 2e-4);
        EXPECT_GT(dot(back->normal, n), 1 - 1e-5);
        ++hits;
    }
    EXPECT_GT(hits, 500);
}

template <class T>
void compare_with_march(const Grid& grid, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> value(-1000, 1000), share(-0.1, 1.1);
    const auto volume = make_volume<T>(grid, [&](Vec3d) { return value(random); });
    TaskArena arena(2);
    const RayCaster caster(volume, arena);
    constexpr double kStep = 2e-3;
    int hits = 0, unseen = 0;
    for (int i = 0; i < 300; ++i) {
        const Vec3i n = grid.size;
        const Vec3d origin =
            world_from_voxel(grid, {share(random) * n.x, share(random) * n.y, share(random) * n.z});
        const Vec3d d = random_unit(random);
        const double iso = 0.5 * value(random);
        const bool rising = i % 2 == 0;
        const auto hit =
            caster.first_hit(origin, d, iso, rising ? Polarity::Rising : Polarity::Falling);
        const double marched = march(volume, origin, d, iso, rising, kStep);
        if (hit) {
            EXPECT_NEAR(trilinear(volume, hit->point_mm), iso, 1e-6) << "seed " << seed;
            EXPECT_LE(dot(hit->normal, d), 1e-9);
        }
        if (marched < 0 && !hit) continue;
        ASSERT_TRUE(hit) << "slipped through, seed " << seed << " ray " << i;
        // The march may step over a turn and back; it never finds one too early.
        if (marched < 0 || hit->distance_mm < marched - 1.01 * kStep) {
            ++unseen;
            continue;
        }
        ASSERT_NEAR(hit->distance_mm, marched, 1.01 * kStep) << "seed " << seed << " ray " << i;
        ++hits;
    }
    EXPECT_GT(hits, 80);
    EXPECT_LT(unseen, 5);
}

TEST(RayCaster, EqualsAFineMarchThroughNoise) {
    compare_with_march<std::int16_t>(plain_grid({12, 11, 10}), 1);
    compare_with_march<float>(odd_grid({11, 19, 9}), 2);
    compare_with_march<std::int16_t>(odd_grid({9, 10, 18}), 3);
}

TEST(RayCaster, LetsNoRaySlipThroughACellsFaces) {
    // A closed shell on 150³ voxels: rays along axes, diagonals and through voxel centres and
    // edges.
    const Grid grid = plain_grid({150, 150, 150});
    const Vec3d centre{75, 75, 75};
    const auto volume = make_volume<std::int16_t>(grid, [&](Vec3d p) {
        const double r = norm(p - centre);
        return -1000 + 2000 * std::clamp(1 - std::abs(r - 60), 0.0, 1.0);
    });
    TaskArena arena(2);
    const RayCaster caster(volume, arena);
    std::mt19937 random(5);
    for (int i = 0; i < 30000; ++i) {
        const auto whole = [&] { return double(int(random() % 101) - 50); };
        const Vec3d d{whole(), whole(), whole()};
        if (norm(d) == 0) continue;
        const Vec3d start = centre + Vec3d{whole() / 10, whole() / 10, whole() / 10};
        const auto hit = caster.first_hit(start, d, -600, Polarity::Rising);
        ASSERT_TRUE(hit) << d.x << ' ' << d.y << ' ' << d.z << " seed 5 ray " << i;
        ASSERT_NEAR(norm(hit->point_mm - centre), 59.5, 1.2);
    }
}

TEST(RayCaster, SeesTheNextWallFromInsideTissue) {
    const Grid grid = plain_grid({60, 5, 5});
    const auto volume = make_volume<std::int16_t>(grid, [](Vec3d p) {
        return p.x < 10 || p.x > 30 ? 0 : -1000;  // tissue, 20 mm of air, tissue
    });
    TaskArena arena(1);
    const RayCaster caster(volume, arena);
    const auto hit = caster.first_hit({4, 2, 2}, {1, 0, 0}, -500, Polarity::Rising);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->point_mm.x, 30.5, 1e-9);
    EXPECT_FALSE(caster.first_hit({40, 2, 2}, {1, 0, 0}, -500, Polarity::Rising));
}

TEST(RayCaster, FindsNothingOutsideOfTheGridOrWithBadRays) {
    const auto volume = make_volume<float>(plain_grid({20, 20, 20}), [](Vec3d p) { return p.x; });
    TaskArena arena(1);
    const RayCaster caster(volume, arena);
    EXPECT_FALSE(caster.first_hit({-5, 30, 5}, {1, 0, 0}, 10, Polarity::Rising));
    EXPECT_FALSE(caster.first_hit({15, 5, 5}, {1, 0, 0}, 10, Polarity::Rising));
    EXPECT_FALSE(caster.first_hit({5, 5, 5}, {0, 0, 0}, 10, Polarity::Rising));
    EXPECT_FALSE(caster.first_hit({5, std::nan(""), 5}, {1, 0, 0}, 10, Polarity::Rising));
    EXPECT_TRUE(caster.first_hit({-5, 5, 5}, {1, 0, 0}, 10, Polarity::Rising));
    EXPECT_TRUE(caster.first_hit({5, 0, 19}, {1, 0, 0}, 10, Polarity::Rising));  // on the border
}

TEST(RayCaster, TakesAVolumeOfOneSliceAsEmpty) {
    const auto volume =
        make_volume<std::int16_t>(plain_grid({9, 9, 1}), [](Vec3d p) { return p.x; });
    TaskArena arena(1);
    const RayCaster caster(volume, arena);
    EXPECT_FALSE(caster.first_hit({0, 4, 0}, {1, 0, 0}, 4, Polarity::Rising));
}

TEST(Bricks, HoldTheRangeOfTheirCellsCorners) {
    std::mt19937 random(3);
    const Grid grid = plain_grid({71, 20, 9});
    const auto volume =
        make_volume<std::int16_t>(grid, [&](Vec3d) { return double(random() % 5000); });
    TaskArena arena(2);
    const render::VoxelField<std::int16_t> field(std::get_if<0>(&volume.voxels)->data(), grid.size);
    const auto bricks = render::make_bricks(field, arena);
    const auto check = [&](const auto& level, int size) {
        for (int z = 0; z < level.size.z; ++z)
            for (int y = 0; y < level.size.y; ++y)
                for (int x = 0; x < level.size.x; ++x) {
                    std::int16_t low = 32767, high = -32768;
                    for (int k = z * size; k <= std::min((z + 1) * size, grid.size.z - 1); ++k)
                        for (int j = y * size; j <= std::min((y + 1) * size, grid.size.y - 1); ++j)
                            for (int i = x * size; i <= std::min((x + 1) * size, grid.size.x - 1);
                                 ++i) {
                                low = std::min(low, *field.at({i, j, k}));
                                high = std::max(high, *field.at({i, j, k}));
                            }
                    EXPECT_EQ(level.at({x, y, z}).min, low);
                    EXPECT_EQ(level.at({x, y, z}).max, high);
                }
    };
    EXPECT_EQ(bricks.fine.size, (Vec3i{9, 3, 1}));
    EXPECT_EQ(bricks.coarse.size, (Vec3i{2, 1, 1}));
    check(bricks.fine, render::kFineCells);
    check(bricks.coarse, render::kCoarseCells);
}

}  // namespace
}  // namespace pliant
