// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Comparison of grids. Files of 32-bit numbers (NIfTI) round origin, spacing and direction, so that
// the grid of a scan that was written and read is not equal to the scan's.

#pragma once

#include <pliant/volume.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {

/// Largest distance between corners of grids that are one [voxels].
inline constexpr double kSameGridVoxels = 0.01;

/// Largest distance of a grid's corner voxels from those of another one [its voxels]; infinite if
/// their sizes differ.
inline double corner_distance(const Grid& grid, const Grid& other) {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    if (grid.size != other.size) return kInfinite;
    double farthest = 0;
    for (int c = 0; c < 8; ++c) {
        Vec3d corner{};
        for (int a = 0; a < 3; ++a) corner[a] = (c >> a & 1) ? other.size[a] - 1 : 0;
        const double by = norm(voxel_from_world(other, world_from_voxel(grid, corner)) - corner);
        if (!std::isfinite(by)) return kInfinite;
        farthest = std::max(farthest, by);
    }
    return farthest;
}

inline bool is_same_grid(const Grid& a, const Grid& b) {
    return a == b || corner_distance(a, b) <= kSameGridVoxels;
}

}  // namespace pliant
