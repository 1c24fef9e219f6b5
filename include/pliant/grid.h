// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The map between voxels and the world.
//
//   world [mm, LPS] = origin_mm + direction · diag(spacing_mm) · ijk
//
// Voxel centres lie at whole ijk. The direction matrix may be oblique or left-handed; its columns
// are perpendicular unit vectors. "Lattice" vectors are in millimetres along the grid's own axes.

#pragma once

#include <pliant/vec.h>

#include <cstddef>

#pragma GCC visibility push(default)
namespace pliant {

/// Half-open box of voxels: begin ≤ ijk < end on every axis.
struct Box3i {
    Vec3i begin{0, 0, 0};
    Vec3i end{0, 0, 0};

    friend constexpr bool operator==(const Box3i&, const Box3i&) = default;
};

constexpr bool is_empty(const Box3i& b) {
    return b.begin.x >= b.end.x || b.begin.y >= b.end.y || b.begin.z >= b.end.z;
}
constexpr bool contains(const Box3i& b, Vec3i p) {
    return p.x >= b.begin.x && p.x < b.end.x && p.y >= b.begin.y && p.y < b.end.y &&
           p.z >= b.begin.z && p.z < b.end.z;
}

struct Grid {
    Vec3i size{0, 0, 0};           ///< voxels along i, j, k
    Vec3d spacing_mm{1, 1, 1};     ///< between voxel centres
    Vec3d origin_mm{0, 0, 0};      ///< centre of voxel (0,0,0), LPS
    Mat3d direction = kIdentity3;  ///< columns: the i, j, k axes in LPS

    friend constexpr bool operator==(const Grid&, const Grid&) = default;
};

constexpr std::size_t voxel_count(const Grid& g) {
    return std::size_t(g.size.x) * std::size_t(g.size.y) * std::size_t(g.size.z);
}
/// Index of voxel ijk in an array with i fastest. @pre ijk inside the grid
constexpr std::size_t voxel_index(const Grid& g, Vec3i p) {
    return std::size_t(p.x) +
           std::size_t(g.size.x) * (std::size_t(p.y) + std::size_t(g.size.y) * std::size_t(p.z));
}
constexpr Box3i voxel_box(const Grid& g) {
    return {{0, 0, 0}, g.size};
}

/// Vector along the grid's axes [mm] → world vector [mm, LPS].
constexpr Vec3d world_from_lattice_vector(const Grid& g, Vec3d v_mm) {
    return g.direction * v_mm;
}
/// World vector [mm, LPS] → vector along the grid's axes [mm].
constexpr Vec3d lattice_from_world_vector(const Grid& g, Vec3d v_mm) {
    return inverse(g.direction) * v_mm;
}
/// Continuous voxel index → world point [mm, LPS].
constexpr Vec3d world_from_voxel(const Grid& g, Vec3d ijk) {
    const Vec3d s = g.spacing_mm;
    return g.origin_mm + g.direction * Vec3d{s.x * ijk.x, s.y * ijk.y, s.z * ijk.z};
}
/// World point [mm, LPS] → continuous voxel index.
constexpr Vec3d voxel_from_world(const Grid& g, Vec3d x_mm) {
    const Vec3d v = lattice_from_world_vector(g, x_mm - g.origin_mm);
    return {v.x / g.spacing_mm.x, v.y / g.spacing_mm.y, v.z / g.spacing_mm.z};
}

}  // namespace pliant
#pragma GCC visibility pop
