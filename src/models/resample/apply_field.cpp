// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/resample.h>

#include <algorithm>
#include <cmath>

#include "base/errors.h"

namespace pliant {
namespace {

/// The outermost voxel centres count as inside if rounding moves them by so much [voxels]: a NIfTI
/// file has positions of 32 bits.
constexpr double kBorderVoxels = 1e-3;

/// Corner of the cell around a continuous voxel index, and the position in the cell; false beyond
/// the outermost voxel centres.
bool cell_of(const Grid& grid, Vec3d ijk, Vec3i& corner, Vec3d& at) {
    for (int a = 0; a < 3; ++a) {
        const int last = grid.size[a] - 1;
        if (!(ijk[a] >= -kBorderVoxels && ijk[a] <= last + kBorderVoxels)) return false;
        const double inside = std::clamp(ijk[a], 0.0, double(last));
        corner[a] = std::clamp(int(inside), 0, std::max(0, last - 1));
        at[a] = inside - corner[a];
    }
    return true;
}

}  // namespace

Vec3d sample_field(const VectorField& field, Vec3d point_mm) {
    const Grid& grid = field.grid;
    Vec3i corner{0, 0, 0};
    Vec3d at{0, 0, 0}, sum{0, 0, 0};
    if (!cell_of(grid, voxel_from_world(grid, point_mm), corner, at)) return sum;
    for (int c = 0; c < 8; ++c) {
        const Vec3i step{c & 1, c >> 1 & 1, c >> 2};
        double weight = 1;
        for (int a = 0; a < 3; ++a) weight *= step[a] ? at[a] : 1 - at[a];
        if (weight == 0) continue;
        const Vec3f v = field.vectors_mm[voxel_index(grid, corner + step)];
        sum = sum + weight * Vec3d{v.x, v.y, v.z};
    }
    return sum;
}

Result<Volume> apply_field(const VectorField& field, const Volume& volume,
                           const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<Volume> {
        if (const Status s = check_field(field); !s.ok()) return s.error();
        if (const Status s = check_volume(volume); !s.ok()) return s.error();
        if (field.kind != FieldKind::Resampling)
            return expected_error("field", "a resampling field (output point to input point)",
                                  "a modeling one");
        const Grid& grid = field.grid;
        Volume out{grid, {}, volume.key_values, volume.background};
        const auto fill = [&](auto values) {
            using T = typename decltype(values)::value_type;
            arena.for_each(grid.size.z, 1, [&](std::int64_t begin, std::int64_t end) {
                for (int k = int(begin); k < int(end); ++k)
                    for (int j = 0; j < grid.size.y; ++j)
                        for (int i = 0; i < grid.size.x; ++i) {
                            const std::size_t n = voxel_index(grid, {i, j, k});
                            const Vec3f u = field.vectors_mm[n];
                            const Vec3d from =
                                world_from_voxel(grid, {double(i), double(j), double(k)}) +
                                Vec3d{u.x, u.y, u.z};
                            const float v =
                                sample_linear(volume, voxel_from_world(volume.grid, from));
                            if constexpr (std::is_same_v<T, std::int16_t>)
                                values[n] = T(std::lround(std::clamp(v, -32768.F, 32767.F)));
                            else
                                values[n] = v;
                        }
            });
            values.freeze();
            out.voxels = std::move(values);
        };
        if (volume.is_16_bit())
            fill(VoxelArray<std::int16_t>(voxel_count(grid)));
        else
            fill(VoxelArray<float>(voxel_count(grid)));
        return out;
    });
}

Result<Volume> jacobian_field(const VectorField& field) noexcept {
    return attempt([&]() -> Result<Volume> {
        if (const Status s = check_field(field); !s.ok()) return s.error();
        const Grid& grid = field.grid;
        const Mat3d to_lattice = inverse(grid.direction);
        VoxelArray<float> values(voxel_count(grid));
        for (int k = 0; k < grid.size.z; ++k)
            for (int j = 0; j < grid.size.y; ++j)
                for (int i = 0; i < grid.size.x; ++i) {
                    const Vec3i p{i, j, k};
                    Mat3d f = kIdentity3;
                    for (int a = 0; a < 3; ++a) {
                        Vec3i low = p, high = p;
                        low[a] = std::max(0, p[a] - 1);
                        high[a] = std::min(grid.size[a] - 1, p[a] + 1);
                        if (low == high) continue;
                        const Vec3f u = field.vectors_mm[voxel_index(grid, low)],
                                    v = field.vectors_mm[voxel_index(grid, high)];
                        const Vec3d by = to_lattice * Vec3d{double(v.x) - u.x, double(v.y) - u.y,
                                                            double(v.z) - u.z};
                        f.columns[a] =
                            f.columns[a] + (1 / (grid.spacing_mm[a] * (high[a] - low[a]))) * by;
                    }
                    values[voxel_index(grid, p)] = float(determinant(f));
                }
        values.freeze();
        return Volume{grid, std::move(values), {}, 1};
    });
}

}  // namespace pliant
