// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A path along the middle of a lumen between two points. It needs no segmentation, only the
// threshold of the pictures (docs/lumen_path.md).

#pragma once

#include <pliant/render.h>
#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/volume.h>

#include <cstdint>
#include <functional>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct LumenPathSettings {
    double iso_hu = -500;
    Polarity polarity = Polarity::Rising;
    /// An end in the tissue, for example a click on a wall, is moved into a lumen within this
    /// distance [mm].
    double reach_mm = 0;
    double spacing_mm = 2;  ///< maximal distance between the path's points
    /// Limit of visited voxels; 13 bytes each.
    std::int64_t max_voxels = 48'000'000;
    std::function<bool()> give_up{};  ///< polled now and then; may be empty
};

struct LumenPath {
    std::vector<Vec3d> points_mm;   ///< LPS, from start to end
    std::vector<double> radius_mm;  ///< distance of each point to the wall
    double length_mm = 0;
};

/// Finds the shortest path that keeps some distance from the walls, then centres it in the lumen.
/// The path stays in the lumen, and is equal for any number of threads. The search visits only
/// voxels up to about the distance of the other end.
/// @pre the volume doesn't change meanwhile
/// @returns InvalidArgument if an end is outside of the volume or in the tissue (the message has
///          the distance to the lumen), NotFound if the ends aren't connected, LimitExceeded if
///          max_voxels are not enough or give_up returned true. Messages begin with "from" or "to"
Result<LumenPath> find_lumen_path(const Volume& volume, Vec3d from_mm, Vec3d to_mm,
                                  const LumenPathSettings& settings, const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
