// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Fast marching [Sethian1996]: a front leaves its seeds and passes each voxel of the lumen once, in
// the order of arrival. |∇arrival| = cost, first order, upwind, over the six neighbours.

#pragma once

#include <functional>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "render/lumen_tiles.h"

namespace pliant::render {

/// The arrival at a voxel, from those of its neighbours: the least T with
///     Σ_a (max(0, T − arrival_a) / spacing_a)² = cost²
/// @param arrival  the lesser one along each axis, infinite where there is none
double eikonal_arrival(Vec3d arrival, Vec3d spacing_mm, double cost);

enum class MarchEnd {
    Reached,    ///< all goals
    Exhausted,  ///< all that is connected to the seeds, and not all goals
    Full,       ///< the tiles are
    GivenUp
};

class March {
  public:
    /// The cost is (1 / distance to the wall)^power, the distance at least a quarter of a voxel.
    March(LumenTiles& tiles, int power);

    double cost(double wall_mm) const;
    /// @pre in the lumen
    void seed(Vec3i voxel, double arrival);
    /// Until the goals' arrivals are final; without goals, until the front has been everywhere.
    MarchEnd run(std::span<const Vec3i> goals, const std::function<bool()>& give_up = {});

    /// From now on, places nearer to this goal come first, by the least that the way there can
    /// cost. Far fewer are passed; arrivals may be a little late.
    /// @param least_cost  per mm, anywhere
    void aim_at(Vec3i goal, double least_cost);

    std::int64_t passed_count() const { return m_passed_count; }

  private:
    /// Arrival, with the way to the goal; equal ones in the order of the voxels.
    using Entry = std::pair<double, std::size_t>;

    Vec3i voxel_of(std::size_t index) const;
    bool pass(Vec3i voxel);
    bool reach(Vec3i voxel);
    double final_arrival(Vec3i voxel);
    void wait(Vec3i voxel, double arrival);

    LumenTiles& m_tiles;
    int m_power;
    Vec3d m_spacing_mm;
    Vec3i m_goal{0, 0, 0};
    double m_least_cost = 0;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> m_waiting;
    std::int64_t m_passed_count = 0;
};

}  // namespace pliant::render
