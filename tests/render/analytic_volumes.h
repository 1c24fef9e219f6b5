// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Analytic volumes and odd grids for the tests of this room.

#pragma once

#include <pliant/render.h>

#include <cmath>
#include <random>

namespace pliant::test {

inline Mat3d rotation(Vec3d axis, double angle) {
    const Vec3d u = normalized(axis);
    const double c = std::cos(angle), s = std::sin(angle);
    const auto turn = [&](Vec3d v) { return c * v + s * cross(u, v) + (1 - c) * dot(u, v) * u; };
    return {{turn({1, 0, 0}), turn({0, 1, 0}), turn({0, 0, 1})}};
}

/// Anisotropic, oblique, left-handed, away from the origin.
inline Grid odd_grid(Vec3i size) {
    Grid grid;
    grid.size = size;
    grid.spacing_mm = {0.8, 1.1, 1.7};
    grid.direction = rotation({1, 2, -1}, 0.7);
    grid.direction.columns[2] = -grid.direction.columns[2];
    grid.origin_mm = {12, -40, 95};
    return grid;
}

inline Grid plain_grid(Vec3i size, Vec3d spacing_mm = {1, 1, 1}) {
    Grid grid;
    grid.size = size;
    grid.spacing_mm = spacing_mm;
    return grid;
}

inline Vec3d centre_mm(const Grid& g) {
    return world_from_voxel(g, {0.5 * (g.size.x - 1), 0.5 * (g.size.y - 1), 0.5 * (g.size.z - 1)});
}

/// Samples value(world point) at every voxel; T: std::int16_t (rounded) or float.
template <class T, class Value>
Volume make_volume(const Grid& grid, const Value& value) {
    Volume volume;
    volume.grid = grid;
    std::vector<T> voxels(voxel_count(grid));
    for (int z = 0; z < grid.size.z; ++z)
        for (int y = 0; y < grid.size.y; ++y)
            for (int x = 0; x < grid.size.x; ++x) {
                const double v = value(world_from_voxel(grid, {double(x), double(y), double(z)}));
                const bool whole = std::is_integral_v<T>;
                voxels[voxel_index(grid, {x, y, z})] = T(whole ? std::round(v) : v);
            }
    volume.voxels = std::move(voxels);
    return volume;
}

/// A tube of air along a line through tissue, with a soft edge.
inline double tube_hu(Vec3d p, Vec3d on_axis, Vec3d axis, double radius_mm) {
    const Vec3d d = p - on_axis;
    const double r = norm(d - dot(d, axis) * axis);
    return -1000 + 1040 * std::clamp(0.5 + 0.5 * (r - radius_mm), 0.0, 1.0);
}

inline Vec3d random_unit(std::mt19937& random) {
    std::normal_distribution<double> gauss;
    return normalized({gauss(random), gauss(random), gauss(random)});
}

}  // namespace pliant::test
