// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scans that are made from surfaces: a voxel's value follows from its distances to them. If a block
// of voxels is far from all surfaces, its middle determines all of its voxels.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace pliant {

/// Grid along the world's axes around nodes, with a margin. Voxels are larger than wanted, in steps
/// of 0.1 mm, if there would be more than max_voxels along an axis; smaller wanted ones likewise in
/// steps of a tenth of them.
inline Grid grid_around(std::span<const Vec3d> nodes_mm, double margin_mm, double voxel_mm,
                        int max_voxels) {
    Vec3d low = nodes_mm.front(), high = low;
    for (const Vec3d& p : nodes_mm)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    const Vec3d span = high - low + Vec3d{2 * margin_mm, 2 * margin_mm, 2 * margin_mm};
    const double longest = std::max({span.x, span.y, span.z});
    const double steps = 10 / voxel_mm;
    const double voxel = std::max(voxel_mm, std::ceil(steps * longest / (max_voxels - 1)) / steps);
    Grid grid;
    for (int a = 0; a < 3; ++a) {
        grid.size[a] = int(std::ceil(span[a] / voxel)) + 1;
        grid.spacing_mm[a] = voxel;
        grid.origin_mm[a] = std::floor((low[a] - margin_mm) / voxel_mm) * voxel_mm;
    }
    return grid;
}

/// @param at     index of a position, with is_far(reach_mm)
/// @param value  of a position and its index, a whole number
template <class At, class Value>
VoxelArray<std::int16_t> filled(const Grid& grid, const TaskArena& arena, const At& at,
                                const Value& value) {
    constexpr int kBlock = 8;
    const double voxel = grid.spacing_mm.x;
    VoxelArray<std::int16_t> values(voxel_count(grid));
    Vec3i blocks;
    for (int a = 0; a < 3; ++a) blocks[a] = (grid.size[a] + kBlock - 1) / kBlock;
    const double half_diagonal = 0.5 * std::sqrt(3.0) * kBlock * voxel;
    const auto fill = [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t b = begin; b < end; ++b) {
            const Vec3i block{int(b % blocks.x), int(b / blocks.x % blocks.y),
                              int(b / blocks.x / blocks.y)};
            const Vec3i first = kBlock * block;
            Vec3d middle;
            for (int a = 0; a < 3; ++a) middle[a] = first[a] + 0.5 * (kBlock - 1);
            const auto at_middle = at(world_from_voxel(grid, middle));
            const bool is_far = at_middle.is_far(half_diagonal + voxel);
            for (int k = first.z; k < std::min(first.z + kBlock, grid.size.z); ++k)
                for (int j = first.y; j < std::min(first.y + kBlock, grid.size.y); ++j)
                    for (int i = first.x; i < std::min(first.x + kBlock, grid.size.x); ++i) {
                        const Vec3d p = world_from_voxel(grid, {double(i), double(j), double(k)});
                        values[voxel_index(grid, {i, j, k})] =
                            std::int16_t(value(p, is_far ? at_middle : at(p)));
                    }
        }
    };
    arena.for_each(std::int64_t(blocks.x) * blocks.y * blocks.z, 1, fill);
    return values;
}

}  // namespace pliant
