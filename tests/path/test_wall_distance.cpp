// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: path/lumen_tiles.cpp, catheter/open_ends.cpp.

#include "path/wall_distance.h"

#include <gtest/gtest.h>

#include "path/lumen_tiles.h"
#include "render/analytic_volumes.h"
#include "support/random.h"

namespace pliant {
namespace {

constexpr int kFarthest = 32;  // voxels

using render::LumenSide;

/// Soft blobs and noise, of either voxel type.
Volume random_volume(test::Random& random, Vec3i size) {
    Grid grid = test::odd_grid(size);
    for (int a = 0; a < 3; ++a) grid.spacing_mm[a] = random.real(0.4, 2);
    const Vec3d k = random.vector(0.8);
    const double noise = random.real(0, 300);
    const auto value = [&](Vec3d x) {
        return 600 * std::sin(dot(k, x)) * std::cos(0.7 * x.x) + random.real(-noise, noise);
    };
    return random.whole(0, 1) ? test::make_volume<std::int16_t>(grid, value)
                              : test::make_volume<float>(grid, value);
}

/// Threshold crossings between neighbours along an axis [mm along the grid's axes].
std::vector<Vec3d> crossings(const Volume& volume, const Box3i& box, const LumenSide& lumen) {
    std::vector<Vec3d> positions;
    const Vec3d s = volume.grid.spacing_mm;
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            for (int x = box.begin.x; x < box.end.x; ++x)
                for (int a = 0; a < 3; ++a) {
                    Vec3i next{x, y, z};
                    if (++next[a] >= box.end[a]) continue;
                    const double v = double(volume.at({x, y, z})), w = double(volume.at(next));
                    const bool in = (v < lumen.iso_hu) == (lumen.polarity == Polarity::Rising);
                    const bool on = (w < lumen.iso_hu) == (lumen.polarity == Polarity::Rising);
                    if (in == on) continue;
                    Vec3d place{double(x), double(y), double(z)};
                    place[a] += (lumen.iso_hu - v) / (w - v);
                    positions.push_back({place.x * s.x, place.y * s.y, place.z * s.z});
                }
    return positions;
}

TEST(WallDistance, IsTheDistanceToTheNearestCrossingByBruteForce) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const Vec3i size{random.whole(1, 12), random.whole(1, 12), random.whole(1, 12)};
        const Volume volume = random_volume(random, size);
        const LumenSide lumen{random.real(-400, 400),
                              random.whole(0, 1) ? Polarity::Rising : Polarity::Falling};
        Box3i box{};
        for (int a = 0; a < 3; ++a) {
            box.begin[a] = random.whole(0, size[a] - 1);
            box.end[a] = random.whole(box.begin[a] + 1, size[a]);
        }
        const auto positions = crossings(volume, box, lumen);
        std::vector<float> found, alone;
        render::wall_distance(volume, box, lumen, TaskArena(4), found);
        render::wall_distance(volume, box, lumen, TaskArena(1), alone);
        EXPECT_EQ(found, alone);
        const Vec3i n = box.end - box.begin;
        ASSERT_EQ(found.size(), std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z));
        const Vec3d s = volume.grid.spacing_mm;
        std::size_t at = 0;
        for (int z = box.begin.z; z < box.end.z; ++z)
            for (int y = box.begin.y; y < box.end.y; ++y)
                for (int x = box.begin.x; x < box.end.x; ++x, ++at) {
                    double nearest = std::numeric_limits<double>::infinity();
                    for (const Vec3d& p : positions)
                        nearest = std::min(nearest, norm(p - Vec3d{x * s.x, y * s.y, z * s.z}));
                    if (std::isinf(nearest)) {
                        ASSERT_TRUE(std::isinf(found[at]));
                    } else {
                        ASSERT_NEAR(double(found[at]), nearest, 1e-3);
                    }
                }
    }
}

TEST(WallDistance, APlaneBetweenVoxelsIsWhereItIs) {
    const Volume volume = test::make_volume<float>(test::plain_grid({20, 9, 9}),
                                                   [](Vec3d x) { return 100 * (x.x - 6.3); });
    std::vector<float> wall;
    render::wall_distance(volume, voxel_box(volume.grid), {0, Polarity::Rising}, TaskArena(1),
                          wall);
    for (int x = 0; x < 20; ++x)
        EXPECT_NEAR(double(wall[voxel_index(volume.grid, {x, 4, 4})]), std::abs(x - 6.3), 1e-4);
}

TEST(LumenTiles, HoldTheDistancesOfTheWholeVolume) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const Vec3i size{random.whole(20, 90), random.whole(20, 90), random.whole(20, 90)};
        Grid grid = test::plain_grid(size, {random.real(0.5, 2), 1, random.real(0.5, 2)});
        const Vec3d middle = test::centre_mm(grid);
        const double radius = random.real(5, 30);
        const Volume volume = test::make_volume<std::int16_t>(
            grid, [&](Vec3d x) { return -1000 + 40 * (norm(x - middle) - radius) + 500; });
        const LumenSide lumen{-500, Polarity::Rising};
        const TaskArena arena(2);
        std::vector<float> whole;
        render::wall_distance(volume, voxel_box(grid), lumen, arena, whole);
        render::LumenTiles tiles(volume, lumen, kFarthest, 1 << 30, arena);
        const double far =
            kFarthest * std::min({grid.spacing_mm.x, grid.spacing_mm.y, grid.spacing_mm.z});
        for (int n = 0; n < 3000; ++n) {
            const Vec3i p{random.whole(0, size.x - 1), random.whole(0, size.y - 1),
                          random.whole(0, size.z - 1)};
            const double d = double(whole[voxel_index(grid, p)]);
            const bool inside = lumen.contains(double(volume.at(p)));
            EXPECT_NEAR(tiles.wall_mm(p), inside ? std::min(d, far) : 0, 1e-5);
        }
    }
}

}  // namespace
}  // namespace pliant
