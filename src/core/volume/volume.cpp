// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Volumes and fields: checks of those from a host, before their grid is used as an index; samples;
// slices.

#include "base/errors.h"
#include "base/text.h"
#include "volume/grid_limits.h"

#include <pliant/volume.h>

#include <cmath>

namespace pliant {
namespace {

constexpr const char* kAxes[] = {"x", "y", "z"};

Error expected(const std::string& field, const std::string& wanted, const std::string& found) {
    return invalid(field + ": expected " + wanted + ", found " + found);
}

Status check_count(const Grid& grid, const std::string& field, std::size_t found) {
    if (found == voxel_count(grid)) return Ok{};
    const auto size = [&](int a) { return std::int64_t(grid.size[a]); };
    return expected(field,
                    std::to_string(voxel_count(grid)) + " of them (" +
                        text_of_sizes({size(0), size(1), size(2)}) + ")",
                    std::to_string(found));
}

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

Status check_grid(const Grid& grid, const std::string& name) {
    for (int a = 0; a < 3; ++a)
        if (grid.size[a] < 1 || grid.size[a] > kMaxAxisSize)
            return expected(name + ".grid.size." + kAxes[a],
                            "1 to " + std::to_string(kMaxAxisSize) + " voxels",
                            std::to_string(grid.size[a]));
    if (voxel_count(grid) > std::size_t(kMaxVoxelCount))
        return expected(name + ".grid.size",
                        "at most " + std::to_string(kMaxVoxelCount) + " voxels",
                        std::to_string(voxel_count(grid)));
    for (int a = 0; a < 3; ++a) {
        const double h = grid.spacing_mm[a];
        if (!(h >= kMinSpacingMm && h <= kMaxSpacingMm))
            return expected(name + ".grid.spacing_mm." + kAxes[a],
                            text_of(kMinSpacingMm) + " to " + text_of(kMaxSpacingMm) + " mm",
                            text_of(h));
    }
    for (int a = 0; a < 3; ++a)
        if (!(std::abs(grid.origin_mm[a]) <= kMaxOriginMm))
            return expected(name + ".grid.origin_mm." + kAxes[a],
                            "a number within " + text_of(kMaxOriginMm) + " mm",
                            text_of(grid.origin_mm[a]));
    if (!is_perpendicular(grid.direction)) {
        const auto& c = grid.direction.columns;
        return expected(
            name + ".grid.direction", "perpendicular unit columns",
            "(" + text_of(c[0]) + "), (" + text_of(c[1]) + "), (" + text_of(c[2]) + ")");
    }
    return Ok{};
}

Status check_volume(const Volume& volume, const std::string& name) {
    if (Status s = check_grid(volume.grid, name); !s) return s;
    return check_count(volume.grid, name + ".voxels",
                       std::visit([](const auto& voxels) { return voxels.size(); }, volume.voxels));
}

Status check_field(const VectorField& field, const std::string& name) {
    if (Status s = check_grid(field.grid, name); !s) return s;
    return check_count(field.grid, name + ".vectors_mm", field.vectors_mm.size());
}

float sample_linear(const Volume& volume, Vec3d ijk) {
    const Vec3i size = volume.grid.size;
    Vec3i first{};
    Vec3d part{};
    for (int a = 0; a < 3; ++a) {
        // Background from one voxel beyond the border on; NaN returns here too.
        if (!(ijk[a] > -1 && ijk[a] < size[a])) return volume.background;
        first[a] = std::int32_t(std::floor(ijk[a]));
        part[a] = ijk[a] - first[a];
    }
    const Box3i inside = voxel_box(volume.grid);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3i step{corner & 1, corner >> 1 & 1, corner >> 2};
        double weight = 1;
        for (int a = 0; a < 3; ++a) weight *= step[a] ? part[a] : 1 - part[a];
        if (weight == 0) continue;
        const Vec3i voxel = first + step;
        sum += weight *
               (contains(inside, voxel) ? double(volume.at(voxel)) : double(volume.background));
    }
    return float(sum);
}

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
