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
#include "base/small_matrix.h"
#include "field/field.h"
#include "resample/fields.h"
#include "resample/snapshot.h"

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

/// The lattice's elements with their neighbours, across bricks.
class Elements {
  public:
    Elements(const Field& field, const TaskArena& arena) : m_field(field) {
        m_snapshot.take(field, {}, arena);
    }

    /// Whether all bricks at or beside a brick of elements are at rest.
    bool is_calm(Vec3i brick) const {
        for (int side = 0; side < 7; ++side) {
            Vec3i there = brick;
            if (side < 6) there[side / 2] += side % 2 ? 1 : -1;
            if (m_snapshot.find(there) >= 0) return false;
        }
        return true;
    }
    /// F = I + ∂u/∂X at an element.
    Mat3d gradient(Vec3i e) const {
        Mat3d f = kIdentity3;
        if (edits(e) & kVoid) return f;
        for (int b = 0; b < 3; ++b) {
            Vec3i high = e, low = e;
            high[b] += is_linked(e, b) ? 1 : 0;
            Vec3i before = e;
            before[b] -= 1;
            if (is_linked(before, b)) low = before;
            const int links = high[b] - low[b];
            if (links == 0) continue;
            const Vec3d u = displacement_mm(high) - displacement_mm(low);
            f.columns[b] = f.columns[b] + (1 / (links * m_field.grid().spacing_mm[b])) * u;
        }
        return f;
    }

  private:
    const BrickRecord* record(Vec3i e) const { return m_snapshot.record_at(m_field.brick_of(e)); }
    int edits(Vec3i e) const {
        const BrickRecord* found = record(e);
        return found && found->edits ? found->edits[m_field.index_in_brick(e)] : 0;
    }
    /// Whether an element is linked to the next one along an axis.
    bool is_linked(Vec3i e, int axis) const {
        Vec3i next = e;
        next[axis] += 1;
        if ((edits(e) & (kCutX << axis | kVoid)) || (edits(next) & kVoid)) return false;
        return !m_field.is_void({-1, 0, 0}) || (is_inside(e) && is_inside(next));
    }
    bool is_inside(Vec3i e) const { return contains(voxel_box(m_field.grid()), e); }
    Vec3d displacement_mm(Vec3i e) const {
        const BrickRecord* found = record(e);
        if (!found) return {0, 0, 0};
        const Vec3<Fixed> u = found->displacement(m_field.index_in_brick(e));
        return {mm_from_units(u.x), mm_from_units(u.y), mm_from_units(u.z)};
    }

    const Field& m_field;
    Snapshot m_snapshot;
};

double largest_strain(const Mat3d& f) {
    Mat3d e = transposed(f) * f;
    for (int a = 0; a < 3; ++a) {
        e.columns[a][a] -= 1;
        e.columns[a] = 0.5 * e.columns[a];
    }
    return largest_eigenvalue(e, Scaling::Quotients);
}

template <class Measure>
Volume field_of(const Field& field, const TaskArena& arena, float at_rest, const char* quantity,
                const Measure& measure) {
    const Grid& grid = field.grid();
    const Elements elements(field, arena);
    std::vector<float> values(voxel_count(grid), at_rest);
    const int size = field.brick_size();
    const int layers = (grid.size.z + size - 1) / size, rows = (grid.size.y + size - 1) / size;
    arena.for_each(std::int64_t(layers) * rows, 1, [&](std::int64_t begin, std::int64_t end) {
        for (; begin < end; ++begin) {
            const int by = int(begin % rows), bz = int(begin / rows);
            for (int x = 0; x < grid.size.x; ++x) {
                if (elements.is_calm({x / size, by, bz})) {
                    x += size - 1 - x % size;
                    continue;
                }
                for (int z = bz * size; z < std::min((bz + 1) * size, grid.size.z); ++z)
                    for (int y = by * size; y < std::min((by + 1) * size, grid.size.y); ++y)
                        values[voxel_index(grid, {x, y, z})] =
                            float(measure(elements.gradient({x, y, z})));
            }
        }
    });
    return {grid, std::move(values), {{"quantity", quantity}, {"unit", "1"}}};
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

// The deformation gradient at each element, and measures derived from it. All of them are invariant
// under rotations of the world, so the scan's direction matrix doesn't matter.

Volume jacobian_of_field(const Field& field, const TaskArena& arena) {
    return field_of(field, arena, 1, "determinant of the deformation gradient",
                    [](const Mat3d& f) { return determinant(f); });
}
Volume strain_of_field(const Field& field, const TaskArena& arena) {
    return field_of(field, arena, 0, "largest principal Green-Lagrange strain", largest_strain);
}

Result<Volume> jacobian_field(const MovingScan& scan) noexcept {
    return attempt([&]() -> Result<Volume> {
        if (const Status s = scan.update_deformation(); !s.ok()) return s.error();
        return jacobian_of_field(scan.deformation().field(), scan.arena());
    });
}
Result<Volume> strain_field(const MovingScan& scan) noexcept {
    return attempt([&]() -> Result<Volume> {
        if (const Status s = scan.update_deformation(); !s.ok()) return s.error();
        return strain_of_field(scan.deformation().field(), scan.arena());
    });
}

}  // namespace pliant
