// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Fast marching [Sethian1996]: a front starts at seeds and passes each lumen voxel once, in the
// order of arrival. |∇arrival| = cost, first-order upwind, over the six neighbours.

#pragma once

#include <functional>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "path/lumen_tiles.h"

namespace pliant::render {

/// Arrival at a voxel from its neighbours: the smallest T with
///     Σ_a (max(0, T − arrival_a) / spacing_a)² = cost²
/// @param arrival  the smaller one along each axis; infinite: none
double eikonal_arrival(Vec3d arrival, Vec3d spacing_mm, double cost);

enum class MarchEnd {
    Reached,    ///< all goals
    Exhausted,  ///< the connected region, but not all goals
    Full,       ///< the tiles are full
    GivenUp
};

class March {
  public:
    /// The cost is (1 / distance to the wall)^power, the distance at least a quarter of a voxel.
    March(LumenTiles& tiles, int power);

    double cost(double wall_mm) const;
    /// Adds a seed. @pre it is in the lumen
    void seed(Vec3i voxel, double arrival);
    /// Runs until the goals' arrivals are final; without goals, until the region is exhausted.
    MarchEnd run(std::span<const Vec3i> goals, const std::function<bool()>& give_up = {});

    /// Switches to A*: voxels nearer to the goal come first, by a lower bound of the remaining
    /// cost. Far fewer voxels are passed; arrivals may be slightly late.
    /// @param least_cost  lower bound of the cost per mm
    void aim_at(Vec3i goal, double least_cost);

    std::int64_t passed_count() const { return m_passed_count; }

  private:
    /// Arrival plus remaining cost, then index as a tie-break.
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
