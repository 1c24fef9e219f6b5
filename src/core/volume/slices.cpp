// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/volume.h>

#include <algorithm>
#include <new>
#include <type_traits>
#include <utility>

#include "base/errors.h"

namespace pliant {
namespace {

/// Copies voxels to a grid; voxel ijk is that of the source at min(ijk, size − 1).
Result<Volume> copied_to(const Volume& source, const Grid& grid) {
    try {
        Volume result{grid, {}, source.key_values};
        std::visit(
            [&](const auto& from) {
                using T = typename std::decay_t<decltype(from)>::value_type;
                VoxelArray<T> to(voxel_count(grid));
                const Vec3i size = source.grid.size;
                std::size_t n = 0;
                for (int k = 0; k < grid.size.z; ++k)
                    for (int j = 0; j < grid.size.y; ++j)
                        for (int i = 0; i < grid.size.x; ++i)
                            to[n++] = from[voxel_index(
                                source.grid, {std::min(i, size.x - 1), std::min(j, size.y - 1),
                                              std::min(k, size.z - 1)})];
                to.freeze();
                result.voxels = std::move(to);
            },
            source.voxels);
        return result;
    } catch (const std::bad_alloc&) {
        return out_of_memory();
    }
}

}  // namespace

Result<Volume> with_doubled_slices(const Volume& volume) noexcept {
    Grid grid = volume.grid;
    Vec3d start{};
    for (int a = 0; a < 3; ++a) {
        if (grid.size[a] > 1) continue;
        grid.size[a] = 2;
        start[a] = -0.5;
    }
    grid.origin_mm = world_from_voxel(grid, start);
    return copied_to(volume, grid);
}

Result<Volume> with_single_slices(const Volume& doubled, const Grid& grid) noexcept {
    return copied_to(doubled, grid);
}

}  // namespace pliant
