// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "path/march.h"

#include <gtest/gtest.h>

#include <queue>

#include "render/analytic_volumes.h"
#include "support/random.h"

namespace pliant {
namespace {

constexpr int kFar = 32;  // voxels

using render::LumenTiles;
using render::March;
using render::MarchEnd;

TEST(March, APlaneWaveArrivesWhenItShould) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const Vec3d spacing{random.real(0.3, 3), random.real(0.3, 3), random.real(0.3, 3)};
        Vec3d slope{random.real(0, 1), random.real(0, 1), random.real(0, 1)};
        if (seed % 3 == 0) slope[int(seed) % 2] = 0;  // along a plane of the grid
        const double cost = norm(slope), start = random.real(0, 50);
        const Vec3d arrival{start - slope.x * spacing.x, start - slope.y * spacing.y,
                            start - slope.z * spacing.z};
        EXPECT_NEAR(render::eikonal_arrival(arrival, spacing, cost), start, 1e-9);
    }
    const double never = std::numeric_limits<double>::infinity();
    EXPECT_DOUBLE_EQ(render::eikonal_arrival({never, 2, never}, {1, 0.5, 1}, 3), 3.5);
    EXPECT_DOUBLE_EQ(render::eikonal_arrival({1, 100, never}, {1, 1, 1}, 1), 2);
}

/// Beside a plane wall with cost 1 / distance, the paths are those of the hyperbolic half-space:
/// cosh(arrival) = 1 + |a − b|² / (2 · distance of a · distance of b).
double half_space_error(double spacing) {
    const int n = int(std::lround(24 / spacing)) + 1;
    const Vec3d source{6, 12, 12};
    const Volume volume =
        test::make_volume<float>(test::plain_grid({n, n, n}, {spacing, spacing, spacing}),
                                 [](Vec3d x) { return 100 * (0.25 - x.x); });
    const TaskArena arena(1);
    LumenTiles tiles(volume, {0, Polarity::Rising}, kFar, 1 << 30, arena);
    March march(tiles, 1);
    const auto exact = [&](Vec3d x) {
        const Vec3d d = x - source;
        return std::acosh(1 + dot(d, d) / (2 * (x.x - 0.25) * (source.x - 0.25)));
    };
    std::vector<Vec3i> goals;
    double worst = 0;
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const Vec3d x{i * spacing, j * spacing, k * spacing};
                // The error right at the source is independent of the grid.
                if (norm(x - source) <= 2.01) march.seed({i, j, k}, exact(x));
                if (x.x >= 3 && norm(x - source) < 7) goals.push_back({i, j, k});
            }
    EXPECT_EQ(march.run({}), MarchEnd::Exhausted);
    for (const Vec3i& goal : goals)
        worst = std::max(
            worst,
            std::abs(tiles.arrival(goal) -
                     exact(spacing * Vec3d{double(goal.x), double(goal.y), double(goal.z)})));
    return worst;
}

TEST(March, ConvergesToTheExactArrivalAsTheGridIsRefined) {
    const double coarse = half_space_error(1), fine = half_space_error(0.5);
    EXPECT_LT(coarse, 0.25) << "of 2.4";
    EXPECT_LT(fine, 0.62 * coarse);
}

struct Maze {
    Volume volume;
    std::vector<Vec3i> lumen;
};

Maze random_maze(test::Random& random) {
    Grid grid = test::plain_grid({random.whole(2, 45), random.whole(2, 12), random.whole(2, 40)},
                                 {random.real(0.5, 2), random.real(0.5, 2), random.real(0.5, 2)});
    const double share = random.real(0.3, 0.8);
    Maze maze{test::make_volume<std::int16_t>(
                  grid, [&](Vec3d) { return random.real(0, 1) < share ? -1000 : 0; }),
              {}};
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i)
                if (maze.volume.at({i, j, k}) < -500) maze.lumen.push_back({i, j, k});
    return maze;
}

/// Shortest paths over the edges of the grid; an edge has the cost of its far end.
std::vector<double> dijkstra(const Maze& maze, LumenTiles& tiles, const March& march, Vec3i seed) {
    using Entry = std::pair<double, std::size_t>;
    const Grid& grid = maze.volume.grid;
    std::vector<double> arrival(voxel_count(grid), std::numeric_limits<double>::infinity());
    std::vector<Vec3i> voxels(arrival.size());
    for (const Vec3i& v : maze.lumen) voxels[voxel_index(grid, v)] = v;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> waiting;
    arrival[voxel_index(grid, seed)] = 0;
    waiting.push({0, voxel_index(grid, seed)});
    while (!waiting.empty()) {
        const auto [t, at] = waiting.top();
        waiting.pop();
        if (t > arrival[at]) continue;
        for (int side = 0; side < 6; ++side) {
            Vec3i next = voxels[at];
            next[side / 2] += side % 2 ? 1 : -1;
            if (!contains(voxel_box(grid), next) || !(maze.volume.at(next) < -500)) continue;
            const double later = t + grid.spacing_mm[side / 2] * march.cost(tiles.wall_mm(next));
            const std::size_t n = voxel_index(grid, next);
            if (!(later < arrival[n])) continue;
            arrival[n] = later;
            waiting.push({later, n});
        }
    }
    return arrival;
}

TEST(March, IsBetweenTheWaysAlongEdgesAndThoseDividedByRootThree) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const Maze maze = random_maze(random);
        if (maze.lumen.empty()) continue;
        LumenTiles tiles(maze.volume, {-500, Polarity::Rising}, kFar, 1 << 30, arena);
        March march(tiles, random.whole(0, 2));
        const Vec3i start = maze.lumen[std::size_t(random.whole(0, int(maze.lumen.size()) - 1))];
        march.seed(start, 0);
        EXPECT_EQ(march.run({}), MarchEnd::Exhausted);
        const auto edges = dijkstra(maze, tiles, march, start);
        std::int64_t reached = 0;
        for (const Vec3i& v : maze.lumen) {
            const double t = tiles.arrival(v), e = edges[voxel_index(maze.volume.grid, v)];
            ASSERT_EQ(std::isinf(t), std::isinf(e));
            if (std::isinf(t)) continue;
            ++reached;
            ASSERT_LE(t, e * (1 + 1e-9));
            ASSERT_GE(t * std::sqrt(3.0), e * (1 - 1e-9));
        }
        EXPECT_EQ(march.passed_count(), reached);
    }
}

TEST(March, EndsAtItsGoalsAndWhenItIsTold) {
    const Volume volume = test::make_volume<std::int16_t>(test::plain_grid({100, 40, 40}),
                                                          [](Vec3d) { return -1000; });
    const auto lumen = render::LumenSide{-500, Polarity::Rising};
    const TaskArena arena(1);
    const Vec3i goal{10, 20, 20};
    {
        LumenTiles tiles(volume, lumen, kFar, 1 << 30, arena);
        March march(tiles, 2);
        march.seed({5, 20, 20}, 0);
        EXPECT_EQ(march.run({&goal, 1}), MarchEnd::Reached);
        EXPECT_LT(march.passed_count(), 2000);
    }
    {
        LumenTiles tiles(volume, lumen, kFar, 40'000, arena);  // room for one tile
        March march(tiles, 2);
        march.seed({5, 20, 20}, 0);
        const Vec3i far{90, 20, 20};
        EXPECT_EQ(march.run({&far, 1}), MarchEnd::Full);
    }
    LumenTiles tiles(volume, lumen, kFar, 1 << 30, arena);
    March march(tiles, 2);
    march.seed({5, 20, 20}, 0);
    int asked = 0;
    EXPECT_EQ(march.run({}, [&] { return ++asked == 3; }), MarchEnd::GivenUp);
}

}  // namespace
}  // namespace pliant
