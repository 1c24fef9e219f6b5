// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Label maps on the grid of a scan, at rest and deformed. A voxel takes the label of the nearest
// voxel; labels are never blended.

#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/errors.h"

namespace pliant {
namespace {

/// Largest distance of corresponding corners of equal grids [voxels].
constexpr double kSameGridVoxels = 0.01;

bool is_same(const Grid& a, const Grid& b) {
    if (a.size != b.size) return false;
    for (int c = 0; c < 8; ++c) {
        Vec3d corner{};
        for (int axis = 0; axis < 3; ++axis) corner[axis] = c >> axis & 1 ? b.size[axis] - 1 : 0;
        const Vec3d there = voxel_from_world(b, world_from_voxel(a, corner));
        if (!(norm(there - corner) <= kSameGridVoxels)) return false;
    }
    return true;
}

/// Keys that describe the voxels' extent in the file, not the segments.
bool is_extent(const std::string& key) {
    return key.ends_with("_Extent") || key == "Segmentation_ReferenceImageExtentOffset";
}

/// Makes labels on a grid.
/// @param source_of_row  for j and k of the grid, the function from i to the map's voxel, a
///                       continuous index
template <class T, class SourceOfRow>
Volume fill(const Volume& labels, const VoxelArray<T>& from, const Grid& grid,
            const TaskArena& arena, const SourceOfRow& source_of_row) {
    VoxelArray<T> to(voxel_count(grid));
    T* const out = to.data();
    const Box3i inside = voxel_box(labels.grid);
    arena.for_each(grid.size.z, 4, [&](std::int64_t begin, std::int64_t end) {
        for (int k = int(begin); k < int(end); ++k)
            for (int j = 0; j < grid.size.y; ++j) {
                const auto source = source_of_row(j, k);
                T* row = out + voxel_index(grid, Vec3i{0, j, k});
                for (int i = 0; i < grid.size.x; ++i) {
                    const Vec3d p = source(i);
                    const Vec3i nearest{int(std::lround(p.x)), int(std::lround(p.y)),
                                        int(std::lround(p.z))};
                    if (contains(inside, nearest)) row[i] = from[voxel_index(labels.grid, nearest)];
                }
            }
    });
    to.freeze();
    Volume result{grid, std::move(to), labels.key_values, 0};
    std::erase_if(result.key_values, [](const auto& pair) { return is_extent(pair.first); });
    return result;
}

template <class SourceOfRow>
Volume fill(const Volume& labels, const Grid& grid, const TaskArena& arena,
            const SourceOfRow& source_of_row) {
    return std::visit(
        [&](const auto& from) { return fill(labels, from, grid, arena, source_of_row); },
        labels.voxels);
}

bool has_any(const Volume& labels) {
    return std::visit(
        [](const auto& voxels) {
            return std::any_of(voxels.begin(), voxels.end(), [](auto value) { return value != 0; });
        },
        labels.voxels);
}

}  // namespace

Result<Volume> labels_on(const Volume& labels, const Grid& grid, const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<Volume> {
        if (const Status s = check_volume(labels, "labels"); !s.ok()) return s.error();
        if (const Status s = check_grid(grid, "grid"); !s.ok()) return s.error();
        if (is_same(labels.grid, grid)) return labels;
        // Voxel of the map = base + i·step + …, as both grids are affine.
        const auto voxel = [&](Vec3d ijk) {
            return voxel_from_world(labels.grid, world_from_voxel(grid, ijk));
        };
        const Vec3d base = voxel({0, 0, 0});
        const Vec3d along_i = voxel({1, 0, 0}) - base, along_j = voxel({0, 1, 0}) - base,
                    along_k = voxel({0, 0, 1}) - base;
        Volume on_grid = fill(labels, grid, arena, [&](int j, int k) {
            const Vec3d row = base + double(j) * along_j + double(k) * along_k;
            return [row, along_i](int i) { return row + double(i) * along_i; };
        });
        if (!has_any(on_grid) && has_any(labels))
            return expected_error("labels", "a label map with labels inside of the scan", "none");
        return on_grid;
    });
}

Result<Volume> deform_labels(const MovingScan& scan, const Deformed& deformed,
                             const Volume& labels) noexcept {
    return attempt([&]() -> Result<Volume> {
        auto rest = labels_on(labels, scan.volume().grid, scan.arena());
        if (!rest) return rest.error();
        const Box3i& box = deformed.dirty_box;
        if (is_empty(box)) return rest;
        const Grid& grid = rest->grid;
        const Volume &before = scan.volume(), &after = deformed.volume;
        const Vec3i size = box.end - box.begin;
        if (deformed.inverse_mm.size() !=
            std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z))
            return expected_error("deformed", "a deformation with its inverse", "none");
        constexpr Vec3d kNowhere{-1, -1, -1};
        return fill(*rest, grid, scan.arena(), [&](int j, int k) {
            return [&, j, k](int i) -> Vec3d {
                const Vec3i p{i, j, k};
                const Vec3d here{double(i), double(j), double(k)};
                if (!contains(box, p)) return here;
                const Vec3i at = p - box.begin;
                const Vec3f u =
                    deformed
                        .inverse_mm[(std::size_t(at.z) * std::size_t(size.y) + std::size_t(at.y)) *
                                        std::size_t(size.x) +
                                    std::size_t(at.x)];
                // Only a gap has another value than the voxel at rest without a source elsewhere.
                if (u == Vec3f{0, 0, 0}) return before.at(p) == after.at(p) ? here : kNowhere;
                const Vec3d source_mm =
                    world_from_voxel(grid, here) + Vec3d{double(u.x), double(u.y), double(u.z)};
                return voxel_from_world(grid, source_mm);
            };
        });
    });
}

}  // namespace pliant
