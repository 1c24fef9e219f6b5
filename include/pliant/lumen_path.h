// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The way through a lumen from one place to another, along the middle: no segmentation, just the
// threshold that the pictures are drawn with (docs/lumen_path.md).

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
    /// An end in the tissue, as a click on a wall is, is moved into a lumen this near [mm].
    double reach_mm = 0;
    double spacing_mm = 2;  ///< between the way's points, at most
    /// Voxels that may be looked at before the search is given up; 13 bytes each.
    std::int64_t max_voxels = 48'000'000;
    std::function<bool()> give_up{};  ///< asked now and then; may be empty
};

struct LumenPath {
    std::vector<Vec3d> points_mm;   ///< LPS, from the one end to the other
    std::vector<double> radius_mm;  ///< distance of each point to the wall
    double length_mm = 0;
};

/// The shortest route that keeps a little off the walls, led to the middle of the lumen along it.
/// It stays in the lumen, and is the same for any number of threads. Of the volume, only what is
/// about as near as the other end is looked at.
/// @pre the volume doesn't change meanwhile
/// @returns InvalidArgument if an end is outside the volume or in the tissue (the message says how
///          far from the lumen), NotFound if no way leads from one to the other, LimitExceeded if
///          max_voxels are not enough or give_up said so. Messages begin with "from" or "to"
Result<LumenPath> find_lumen_path(const Volume& volume, Vec3d from_mm, Vec3d to_mm,
                                  const LumenPathSettings& settings, const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
