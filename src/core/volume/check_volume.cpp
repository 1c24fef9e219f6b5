// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Checks of volumes and fields from a host, before their grid is used as an index.

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

}  // namespace pliant
