// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Label maps of analytic shapes.

#pragma once

#include <pliant/volume.h>

#include <cmath>
#include <cstdint>
#include <functional>

namespace pliant::test {

/// Voxels with label 1 where inside(point [mm]) holds.
inline Volume shape(const Grid& grid, const std::function<bool(Vec3d)>& inside) {
    VoxelArray<std::int16_t> voxels(voxel_count(grid));
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i)
                voxels[voxel_index(grid, {i, j, k})] =
                    inside(world_from_voxel(grid, {double(i), double(j), double(k)}));
    return {grid, std::move(voxels), {}};
}

inline bool in_ellipsoid(Vec3d x, Vec3d centre, Vec3d radii) {
    const Vec3d d = x - centre;
    return std::hypot(d.x / radii.x, d.y / radii.y, d.z / radii.z) <= 1;
}

/// 160 × 128 × 160 mm around the origin, voxels of 2.5 mm.
inline Grid cube_grid() {
    return {{64, 52, 64}, {2.5, 2.5, 2.5}, {-80, -65, -80}, kIdentity3};
}

}  // namespace pliant::test
