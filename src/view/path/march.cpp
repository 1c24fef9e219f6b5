// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "path/march.h"

#include <algorithm>
#include <cmath>

namespace pliant::render {
namespace {

constexpr double kNearestVoxels = 0.25;  // smaller distances to the wall don't increase the cost
constexpr std::int64_t kAskEvery = 1 << 14;  // voxels

}  // namespace

double eikonal_arrival(Vec3d arrival, Vec3d spacing_mm, double cost) {
    int order[3] = {0, 1, 2};
    std::sort(order, order + 3, [&](int a, int b) { return arrival[a] < arrival[b]; });
    // Σ w (T − t)² = cost², w = 1 / spacing², over the first one, two or three neighbours.
    double w = 0, wt = 0, wtt = 0, best = std::numeric_limits<double>::infinity();
    for (int a : order) {
        const double t = arrival[a];
        if (!(t < best)) break;  // it would be later than the result
        const double weight = 1 / (spacing_mm[a] * spacing_mm[a]);
        w += weight;
        wt += weight * t;
        wtt += weight * t * t;
        const double square = wt * wt - w * (wtt - cost * cost);
        best = std::min(best, (wt + std::sqrt(std::max(square, 0.0))) / w);
    }
    return best;
}

March::March(LumenTiles& tiles, int power)
    : m_tiles(tiles), m_power(power), m_spacing_mm(tiles.volume().grid.spacing_mm) {}

double March::cost(double wall_mm) const {
    const double nearest =
        kNearestVoxels * std::min({m_spacing_mm.x, m_spacing_mm.y, m_spacing_mm.z});
    const double per_mm = 1 / std::max(wall_mm, nearest);
    double cost = 1;
    for (int n = 0; n < m_power; ++n) cost *= per_mm;
    return cost;
}

Vec3i March::voxel_of(std::size_t index) const {
    const Vec3i n = m_tiles.volume().grid.size;
    const auto x = std::size_t(n.x), y = std::size_t(n.y);
    return {int(index % x), int(index / x % y), int(index / (x * y))};
}

void March::seed(Vec3i voxel, double arrival) {
    LumenTile* tile = m_tiles.tile_of(voxel);
    if (!tile) return;
    double& known = tile->arrival[LumenTiles::index_in_tile(voxel)];
    if (!(arrival < known)) return;
    known = arrival;
    tile->set[LumenTiles::index_in_tile(voxel)] = kOpen;
    wait(voxel, arrival);
}

void March::aim_at(Vec3i goal, double least_cost) {
    m_goal = goal;
    m_least_cost = least_cost;
}

void March::wait(Vec3i voxel, double arrival) {
    const Vec3i d = m_goal - voxel;
    const double way = norm({d.x * m_spacing_mm.x, d.y * m_spacing_mm.y, d.z * m_spacing_mm.z});
    m_waiting.push({arrival + m_least_cost * way, voxel_index(m_tiles.volume().grid, voxel)});
}

double March::final_arrival(Vec3i voxel) {
    const double kNone = std::numeric_limits<double>::infinity();
    if (!m_tiles.is_inside(voxel)) return kNone;
    const LumenTile* tile = m_tiles.tile_of(voxel);
    if (!tile) return kNone;
    const std::size_t at = LumenTiles::index_in_tile(voxel);
    return tile->set[at] == kFinal ? tile->arrival[at] : kNone;
}

/// Updates a neighbour of a passed voxel. @returns false if the tiles are full
bool March::reach(Vec3i voxel) {
    LumenTile* tile = m_tiles.tile_of(voxel);
    if (!tile) return false;
    const std::size_t at = LumenTiles::index_in_tile(voxel);
    if (tile->set[at] != kOpen || !m_tiles.lumen().contains(double(m_tiles.volume().at(voxel))))
        return true;
    Vec3d arrival{};
    for (int a = 0; a < 3; ++a) {
        Vec3i before = voxel, after = voxel;
        --before[a];
        ++after[a];
        arrival[a] = std::min(final_arrival(before), final_arrival(after));
    }
    const double t = eikonal_arrival(arrival, m_spacing_mm, cost(double(tile->wall_mm[at])));
    if (t < tile->arrival[at]) {
        tile->arrival[at] = t;
        wait(voxel, t);
    }
    return true;
}

bool March::pass(Vec3i voxel) {
    for (int side = 0; side < 6; ++side) {
        Vec3i next = voxel;
        next[side / 2] += side % 2 ? 1 : -1;
        if (m_tiles.is_inside(next) && !reach(next)) return false;
    }
    return true;
}

MarchEnd March::run(std::span<const Vec3i> goals, const std::function<bool()>& give_up) {
    std::size_t left = goals.size();
    while (!m_waiting.empty()) {
        const Vec3i voxel = voxel_of(m_waiting.top().second);
        m_waiting.pop();
        LumenTile* tile = m_tiles.tile_of(voxel);
        const std::size_t at = LumenTiles::index_in_tile(voxel);
        if (!tile || tile->set[at] != kOpen) continue;  // already reached by an earlier path
        tile->set[at] = kFinal;
        if (m_passed_count++ % kAskEvery == 0 && give_up && give_up()) return MarchEnd::GivenUp;
        left -= std::size_t(std::count(goals.begin(), goals.end(), voxel));
        if (!pass(voxel)) return MarchEnd::Full;
        if (left == 0 && !goals.empty()) return MarchEnd::Reached;
    }
    return MarchEnd::Exhausted;
}

}  // namespace pliant::render
