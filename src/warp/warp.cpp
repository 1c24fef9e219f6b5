// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/warp.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/errors.h"
#include "field/field.h"
#include "volume/boxes.h"

namespace pliant {
namespace {

Vec3d scaled(Vec3d a, Vec3d b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

std::int64_t count_of(const Box3i& box) {
    return is_empty(box) ? 0 : box_count(box);
}

Box3i box_of(const Field& field, const FieldBrick& brick) {
    const Vec3i last = field.element_of(brick.coord, field.elements_per_brick() - 1);
    return {field.element_of(brick.coord, 0), last + Vec3i{1, 1, 1}};
}

/// The displacements of all bricks, over a box around them.
WarpState state_of_field(const Field& field) {
    WarpState state{field.grid(), {}, {}};
    field.for_each_brick([&](const FieldBrick& brick) {
        if (!is_at_rest(brick)) state.box = hull(state.box, box_of(field, brick));
    });
    if (is_empty(state.box)) return state;
    const Vec3i n = state.box.end - state.box.begin;
    const std::size_t count = dense_count(n);
    state.units.assign(3 * count, 0);
    const int size = field.brick_size();
    field.for_each_brick([&](const FieldBrick& brick) {
        if (is_at_rest(brick) || brick.is_unplaced) return;
        const Vec3i first = field.element_of(brick.coord, 0) - state.box.begin;
        for (std::size_t a = 0; a < 3; ++a)
            for (int row = 0; row < size * size; ++row)
                std::copy_n(
                    brick.u[a] + std::ptrdiff_t(row) * size, size,
                    state.units.begin() + std::ptrdiff_t(a * count) +
                        std::ptrdiff_t(dense_index(first + Vec3i{0, row % size, row / size}, n)));
    });
    return state;
}

/// A deformation of a grid without a tissue.
class Bare final : public MovingScan {
  public:
    Bare(const Grid& grid, Deformation deformation, const TaskArena& arena)
        : m_volume{grid, VoxelArray<std::int16_t>(voxel_count(grid)), {}},
          m_deformation(std::move(deformation)),
          m_arena(arena) {}
    const Volume& volume() const override { return m_volume; }
    const Deformation& deformation() const override { return m_deformation; }
    const TaskArena& arena() const override { return m_arena; }

  private:
    Volume m_volume;
    Deformation m_deformation;
    const TaskArena& m_arena;
};

Result<Deformation> deformation_of(const WarpState& state) {
    auto deformation = Deformation::create(state.grid);
    if (!deformation.ok() || is_empty(state.box)) return deformation;
    const auto count = std::size_t(count_of(state.box));
    std::vector<Vec3d> displacements_mm(count);
    for (std::size_t n = 0; n < count; ++n)
        displacements_mm[n] = world_from_lattice_vector(
            state.grid, {mm_from_units(state.units[n]), mm_from_units(state.units[count + n]),
                         mm_from_units(state.units[2 * count + n])});
    if (const Status s = deformation->write(state.box, displacements_mm); !s.ok()) return s.error();
    return deformation;
}

/// Turns φ⁻¹(p) − p from LPS millimetres to voxels.
void turn_to_voxels(const Grid& grid, std::vector<Vec3f>& back) {
    const Mat3d turn = inverse(grid.direction);
    Vec3f rows[3];
    for (int a = 0; a < 3; ++a)
        rows[a] = {float(turn.columns[0][a] / grid.spacing_mm[a]),
                   float(turn.columns[1][a] / grid.spacing_mm[a]),
                   float(turn.columns[2][a] / grid.spacing_mm[a])};
    for (Vec3f& b : back)
        if (b != Vec3f{0, 0, 0}) b = {dot(rows[0], b), dot(rows[1], b), dot(rows[2], b)};
}

}  // namespace

/// A cell that holds a point, with the displacements of its corners [voxels].
class WarpCell {
  public:
    /// @param at  continuous voxel index
    WarpCell(const Warp& warp, Vec3d at) : m_warp(warp) { move_to(at); }

    void move_to(Vec3d at) {
        const Vec3i low{int(std::floor(at.x)), int(std::floor(at.y)), int(std::floor(at.z))};
        m_at = at - Vec3d{double(low.x), double(low.y), double(low.z)};
        if (m_is_read && low == m_low) return;
        m_low = low;
        m_is_read = true;
        const Vec3d h = m_warp.grid().spacing_mm;
        for (int n = 0; n < 8; ++n)
            m_corners[n] = scaled({1 / h.x, 1 / h.y, 1 / h.z},
                                  m_warp.displacement_mm(low + Vec3i{n & 1, n >> 1 & 1, n >> 2}));
    }
    Vec3d displacement() const {
        Vec3d sum{0, 0, 0};
        for (int n = 0; n < 8; ++n)
            sum = sum + weight(n, 0) * weight(n, 1) * weight(n, 2) * m_corners[n];
        return sum;
    }
    /// ∂φ/∂X
    Mat3d gradient() const {
        Mat3d gradient = kIdentity3;
        for (int n = 0; n < 8; ++n)
            for (int a = 0; a < 3; ++a) {
                const double slope =
                    (n >> a & 1 ? 1 : -1) * weight(n, (a + 1) % 3) * weight(n, (a + 2) % 3);
                Vec3d& column = gradient.columns[std::size_t(a)];
                column = column + slope * m_corners[n];
            }
        return gradient;
    }

  private:
    double weight(int corner, int axis) const {
        return corner >> axis & 1 ? m_at[axis] : 1 - m_at[axis];
    }

    const Warp& m_warp;
    bool m_is_read = false;
    Vec3i m_low{0, 0, 0};
    Vec3d m_at{0, 0, 0};
    Vec3d m_corners[8];
};

Result<Warp> Warp::create(const MovingScan& scan, Volume* deformed) noexcept {
    return attempt([&]() -> Result<Warp> {
        auto made = deform_volume(scan, Mapping::Cells, true);
        if (!made.ok()) return made.error();
        const Field& field = scan.deformation().field();
        if (field.may_have_gaps())
            return about("warp", ErrorCode::InvalidArgument,
                         "expected a deformation without cut, carved or missing elements");
        Warp warp;
        warp.m_state = state_of_field(field);
        warp.m_changed = made->dirty_box;
        warp.m_back = std::move(made->inverse_mm);
        turn_to_voxels(warp.grid(), warp.m_back);
        warp.m_has_inverse = true;
        if (deformed) *deformed = std::move(made->volume);
        return warp;
    });
}

Result<Warp> Warp::create(WarpState state, const TaskArena& arena, bool with_inverse) noexcept {
    return attempt([&]() -> Result<Warp> {
        if (const Status s = check_grid(state.grid, "warp"); !s.ok()) return s.error();
        const std::int64_t expected = 3 * count_of(state.box);
        if (std::int64_t(state.units.size()) != expected)
            return expected_error("warp", std::to_string(expected) + " displacements",
                                  std::to_string(state.units.size()));
        if (with_inverse) {
            auto deformation = deformation_of(state);
            if (!deformation.ok()) return deformation.error();
            return create(Bare(state.grid, std::move(*deformation), arena));
        }
        Warp warp;
        warp.m_state = std::move(state);
        return warp;
    });
}

Vec3d Warp::displacement_mm(Vec3i ijk) const {
    const Box3i& box = m_state.box;
    if (!contains(box, ijk)) return {0, 0, 0};
    const std::size_t count = m_state.units.size() / 3;
    const std::size_t n = dense_index(ijk - box.begin, box.end - box.begin);
    return {mm_from_units(m_state.units[n]), mm_from_units(m_state.units[count + n]),
            mm_from_units(m_state.units[2 * count + n])};
}

Vec3d Warp::forward(Vec3d point_mm) const {
    const Vec3d ijk = voxel_from_world(grid(), point_mm);
    if (!(norm(ijk) < 1e8)) return point_mm;
    const Vec3d moved = WarpCell(*this, ijk).displacement();
    if (moved == Vec3d{0, 0, 0}) return point_mm;
    return point_mm + world_from_lattice_vector(grid(), scaled(grid().spacing_mm, moved));
}

std::optional<Vec3d> Warp::inverse(Vec3d point_mm) const {
    constexpr double kClose = 1e-10;  // [voxels]
    constexpr int kNewtonSteps = 30, kSteps = 5000;
    const Vec3d target = voxel_from_world(grid(), point_mm);
    if (!(norm(target) < 1e8)) return point_mm;
    WarpCell cell(*this, target);
    Vec3d at = target - cell.displacement();
    for (int n = 0; n < kSteps; ++n) {
        cell.move_to(at);
        const Vec3d left = target - at - cell.displacement();
        if (std::max({std::abs(left.x), std::abs(left.y), std::abs(left.z)}) < kClose) {
            if (at == target) return point_mm;
            return point_mm +
                   world_from_lattice_vector(grid(), scaled(grid().spacing_mm, at - target));
        }
        // Newton's steps can circle between cells. Where limits rule out folds, u contracts.
        const Mat3d gradient = cell.gradient();
        at = at + (n < kNewtonSteps && determinant(gradient) > 0 ? pliant::inverse(gradient) * left
                                                                 : left);
    }
    return std::nullopt;
}

Result<VectorField> Warp::forward_field() const noexcept {
    return attempt([&]() -> Result<VectorField> {
        VectorField field{grid(), FieldKind::Modeling,
                          std::vector<Vec3f>(voxel_count(grid()), {0, 0, 0})};
        for_each_in(overlap(m_state.box, voxel_box(grid())), [&](Vec3i ijk) {
            const Vec3d u = world_from_lattice_vector(grid(), displacement_mm(ijk));
            field.vectors_mm[voxel_index(grid(), ijk)] = {float(u.x), float(u.y), float(u.z)};
        });
        return field;
    });
}

Result<VectorField> Warp::inverse_field() const noexcept {
    return attempt([&]() -> Result<VectorField> {
        VectorField field{grid(), FieldKind::Resampling,
                          std::vector<Vec3f>(voxel_count(grid()), {0, 0, 0})};
        const Vec3d h = grid().spacing_mm;
        auto back = m_back.begin();
        for_each_in(m_changed, [&](Vec3i ijk) {
            const Vec3f b = *back++;
            const Vec3d mm = world_from_lattice_vector(grid(), {h.x * b.x, h.y * b.y, h.z * b.z});
            field.vectors_mm[voxel_index(grid(), ijk)] = {float(mm.x), float(mm.y), float(mm.z)};
        });
        return field;
    });
}

std::int64_t Warp::moved_elements() const {
    const std::size_t count = m_state.units.size() / 3;
    const std::int32_t* const u = m_state.units.data();
    std::int64_t moved = 0;
    for (std::size_t n = 0; n < count; ++n) moved += (u[n] | u[count + n] | u[2 * count + n]) != 0;
    return moved;
}

}  // namespace pliant
