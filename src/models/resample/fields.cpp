// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacement fields, as a whole and slice by slice. A slice reads only the bricks that it cuts.

#include <pliant/resample.h>

#include <algorithm>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "base/errors.h"
#include "resample/fields.h"

namespace pliant {
namespace {

std::size_t slice_size(const Grid& grid) {
    return std::size_t(grid.size.x) * std::size_t(grid.size.y);
}

/// Fills the part of slice k that lies in a brick.
void fill_from_brick(const Field& field, const FieldBrick& brick, int k,
                     std::span<Vec3f> vectors_mm) {
    const Grid& grid = field.grid();
    const Vec3i first = field.element_of(brick.coord, 0);
    const int size = field.element_of(brick.coord, field.elements_per_brick() - 1).z - first.z + 1;
    const int begin = size * size * (k - first.z);
    for (int n = begin; n < begin + size * size; ++n) {
        const Vec3i e = field.element_of(brick.coord, n);
        if (!contains(voxel_box(grid), e)) continue;
        const auto i = std::size_t(n);
        const Vec3d u = world_from_lattice_vector(
            grid, {mm_from_units(brick.u[0][i]), mm_from_units(brick.u[1][i]),
                   mm_from_units(brick.u[2][i])});
        vectors_mm[voxel_index(grid, {e.x, e.y, 0})] = {float(u.x), float(u.y), float(u.z)};
    }
}

VectorField whole_field(const Grid& grid, FieldKind kind, const FieldSlices& fill_slice) {
    VectorField field{grid, kind, std::vector<Vec3f>(voxel_count(grid), {0, 0, 0})};
    const std::span all(field.vectors_mm);
    for (int k = 0; k < grid.size.z; ++k)
        fill_slice(k, all.subspan(std::size_t(k) * slice_size(grid), slice_size(grid)));
    return field;
}

}  // namespace

FieldSlices slices_of(const Field& field) {
    // Bricks by layer.
    auto layers = std::make_shared<std::map<int, std::vector<int>>>();
    for (const int index : field.resident_bricks())
        (*layers)[field.brick(index).coord.z].push_back(index);
    return [&field, layers](int k, std::span<Vec3f> vectors_mm) {
        const auto found = layers->find(field.brick_of({0, 0, k}).z);
        if (found == layers->end()) return;
        for (const int index : found->second)
            fill_from_brick(field, field.brick(index), k, vectors_mm);
    };
}

Result<FieldSlices> displacement_slices(const MovingScan& scan) noexcept {
    return attempt([&]() -> Result<FieldSlices> {
        if (const Status s = scan.update_deformation(); !s.ok()) return s.error();
        return slices_of(scan.deformation().field());
    });
}

FieldSlices inverse_slices(const Deformed& deformed) noexcept {
    return [&deformed](int k, std::span<Vec3f> vectors_mm) {
        const Grid& grid = deformed.volume.grid;
        const Box3i& box = deformed.dirty_box;
        if (is_empty(box) || k < box.begin.z || k >= box.end.z) return;
        const Vec3i size = box.end - box.begin;
        auto from = deformed.inverse_mm.begin() +
                    std::ptrdiff_t(size.x) * size.y * std::ptrdiff_t(k - box.begin.z);
        for (int y = box.begin.y; y < box.end.y; ++y, from += size.x)
            std::copy_n(
                from, size.x,
                vectors_mm.begin() + std::ptrdiff_t(voxel_index(grid, {box.begin.x, y, 0})));
    };
}

Result<VectorField> displacement_field(const MovingScan& scan) noexcept {
    return attempt([&]() -> Result<VectorField> {
        const Result<FieldSlices> slices = displacement_slices(scan);
        if (!slices) return slices.error();
        return whole_field(scan.volume().grid, FieldKind::Modeling, *slices);
    });
}

Result<VectorField> inverse_field(const Deformed& deformed) noexcept {
    return attempt([&]() -> Result<VectorField> {
        return whole_field(deformed.volume.grid, FieldKind::Resampling, inverse_slices(deformed));
    });
}

}  // namespace pliant
