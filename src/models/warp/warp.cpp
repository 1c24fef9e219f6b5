// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/data/warp.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "base/errors.h"
#include "field/cell_block.h"
#include "field/field.h"
#include "field/fixed_point.h"
#include "resample/find_source.h"
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

/// The cells of a state, as find_source.h asks.
class WarpCells {
  public:
    explicit WarpCells(const WarpState& state)
        : m_state(state), m_scale(voxels_per_unit(state.grid)) {}

    bool corners(Vec3i cell, std::array<Vec3d, 8>& points) const {
        const Vec3i first = cell - m_state.box.begin, n = m_state.box.end - m_state.box.begin;
        for (int a = 0; a < 3; ++a)
            if (first[a] < -1 || first[a] >= n[a]) return false;
        const std::size_t count = m_state.units.size() / 3;
        bool moved = false;
        for (int c = 0; c < 8; ++c) {
            const Vec3i step{c & 1, c >> 1 & 1, c >> 2};
            Vec3d& point = points[std::size_t(c)];
            point = real_of(step);
            if (!contains(m_state.box, cell + step)) continue;
            const std::size_t at = dense_index(first + step, n);
            for (int a = 0; a < 3; ++a) {
                const std::int32_t u = m_state.units[std::size_t(a) * count + at];
                moved = moved || u != 0;
                point[a] += m_scale[a] * u;
            }
        }
        return moved;
    }
    bool is_whole(Vec3i) const { return true; }
    /// Reads all displacements: few searches are needed.
    DisplacementBounds bounds() const {
        DisplacementBounds bounds;
        const std::size_t count = m_state.units.size() / 3;
        if (count == 0) return bounds;
        for (int a = 0; a < 3; ++a) {
            const auto first = m_state.units.begin() + std::ptrdiff_t(std::size_t(a) * count);
            const auto [low, high] = std::minmax_element(first, first + std::ptrdiff_t(count));
            bounds.min[a] = std::min(0.0, m_scale[a] * *low);
            bounds.max[a] = std::max(0.0, m_scale[a] * *high);
        }
        return bounds;
    }

  private:
    const WarpState& m_state;
    Vec3d m_scale;
};

/// u at a continuous voxel index [voxels].
Vec3d displacement_at(const Warp& warp, Vec3d at) {
    const Vec3i low = floor_of(at);
    const Vec3d h = warp.grid().spacing_mm, per_mm{1 / h.x, 1 / h.y, 1 / h.z};
    const Vec3d high = at - real_of(low), weights[2] = {Vec3d{1, 1, 1} - high, high};
    Vec3d sum{0, 0, 0};
    for (int n = 0; n < 8; ++n) {
        const Vec3i step{n & 1, n >> 1 & 1, n >> 2};
        const double weight = weights[step.x].x * weights[step.y].y * weights[step.z].z;
        sum = sum + weight * scaled(per_mm, warp.displacement_mm(low + step));
    }
    return sum;
}

/// Differences of one component at the elements of a row, to the elements at −1 and +1 along each
/// axis, as a fraction of the spacing there.
struct Slopes {
    std::array<std::vector<float>, 6> of;  ///< 2·axis + (forward)
};

/// Displacements with two layers of elements at rest around them.
class Padded {
  public:
    explicit Padded(const WarpState& state)
        : m_size(state.box.end - state.box.begin + Vec3i{4, 4, 4}), m_state(state) {}

    Vec3i size() const { return m_size; }
    /// The row of component a whose first element is at padded (0, y, z).
    void read_row(int a, int y, int z, std::vector<std::int32_t>& row) const {
        row.assign(std::size_t(m_size.x), 0);
        const Vec3i n = m_size - Vec3i{4, 4, 4};
        if (y < 2 || z < 2 || y >= n.y + 2 || z >= n.z + 2) return;
        const std::size_t first =
            std::size_t(a) * dense_count(n) + dense_index({0, y - 2, z - 2}, n);
        std::copy_n(m_state.units.begin() + std::ptrdiff_t(first), n.x, row.begin() + 2);
    }

  private:
    Vec3i m_size;
    const WarpState& m_state;
};

float smallest_in_row(const std::array<Slopes, 3>& slopes, std::size_t count) {
    float smallest = 1;
    for (unsigned side = 0; side < 8; ++side) {
        const auto column = [&](std::size_t a, std::size_t b) {
            return slopes[a].of[2 * b + (side >> b & 1)].data();
        };
        const float *xx = column(0, 0), *xy = column(0, 1), *xz = column(0, 2);
        const float *yx = column(1, 0), *yy = column(1, 1), *yz = column(1, 2);
        const float *zx = column(2, 0), *zy = column(2, 1), *zz = column(2, 2);
        for (std::size_t n = 0; n < count; ++n) {
            const float a = 1 + xx[n], e = 1 + yy[n], i = 1 + zz[n];
            const float d = a * (e * i - yz[n] * zy[n]) - xy[n] * (yx[n] * i - yz[n] * zx[n]) +
                            xz[n] * (yx[n] * zy[n] - e * zx[n]);
            smallest = d < smallest ? d : smallest;
        }
    }
    return smallest;
}

}  // namespace

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
    const Vec3d moved = displacement_at(*this, ijk);
    if (moved == Vec3d{0, 0, 0}) return point_mm;
    return point_mm + world_from_lattice_vector(grid(), scaled(grid().spacing_mm, moved));
}

std::optional<Vec3d> Warp::inverse(Vec3d point_mm) const {
    const Vec3d now = voxel_from_world(grid(), point_mm);
    if (!(norm(now) < 1e8)) return point_mm;
    WarpCells cells(m_state);
    const auto rest = find_source(cells, now);
    if (!rest) return std::nullopt;
    if (*rest == now) return point_mm;
    return point_mm + world_from_lattice_vector(grid(), scaled(grid().spacing_mm, *rest - now));
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
        auto back = m_back.begin();
        for_each_row(m_changed, [&](Vec3i first) {
            const auto count = m_changed.end.x - first.x;
            std::copy_n(back, count,
                        field.vectors_mm.begin() + std::ptrdiff_t(voxel_index(grid(), first)));
            back += count;
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

// The smallest Jacobian of a warp. At a corner of a trilinear cell, the columns of ∂φ/∂X are the
// cell's three edges there. So the eight determinants at an element have its forward or backward
// differences along each axis.

double Warp::smallest_jacobian() const {
    if (is_empty(m_state.box)) return 1;
    const Padded padded(m_state);
    const Vec3i n = padded.size();
    const auto count = std::size_t(n.x - 2);  // rows without their first and last element
    std::array<Slopes, 3> slopes;
    for (Slopes& s : slopes)
        for (auto& values : s.of) values.resize(count);
    std::vector<std::int32_t> row, other;
    double smallest = 1;
    for (int z = 1; z < n.z - 1; ++z)
        for (int y = 1; y < n.y - 1; ++y) {
            for (int a = 0; a < 3; ++a) {
                padded.read_row(a, y, z, row);
                for (int b = 0; b < 3; ++b)
                    for (int forward = 0; forward < 2; ++forward) {
                        const int step = forward ? 1 : -1;
                        const int shift = b == 0 ? step : 0;
                        if (b == 0)
                            other = row;
                        else
                            padded.read_row(a, y + (b == 1 ? step : 0), z + (b == 2 ? step : 0),
                                            other);
                        // F = I + ∂u/∂X, with u_a in mm: det is the same in any units.
                        const auto scale = float(step / (grid().spacing_mm[b] * kUnitsPerMm));
                        float* const to =
                            slopes[std::size_t(a)].of[std::size_t(2 * b + forward)].data();
                        const std::int32_t* const at = row.data() + 1;
                        const std::int32_t* const beside = other.data() + 1 + shift;
                        for (std::size_t i = 0; i < count; ++i)
                            to[i] = scale * float(beside[i] - at[i]);
                    }
            }
            smallest = std::min(smallest, double(smallest_in_row(slopes, count)));
        }
    return smallest;
}

}  // namespace pliant
