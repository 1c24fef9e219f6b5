// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A warp's images and labels, there and back.

#include <algorithm>

#include "field/fixed_point.h"
#include "volume/boxes.h"
#include "warp/sampling.h"

namespace pliant {
namespace {

/// Calls visit(ijk, offset) for the voxels whose value comes from ijk + offset ≠ ijk [voxels].
/// @param back  φ⁻¹(p) − p over the box [mm, LPS]
template <class Visit>
void for_sources(const Grid& grid, const Box3i& changed, const Vec3f* back, const Visit& visit) {
    const Mat3d turn = inverse(grid.direction);
    Vec3f rows[3];
    for (int a = 0; a < 3; ++a)
        rows[a] = {float(turn.columns[0][a] / grid.spacing_mm[a]),
                   float(turn.columns[1][a] / grid.spacing_mm[a]),
                   float(turn.columns[2][a] / grid.spacing_mm[a])};
    for_each_row(changed, [&](Vec3i p) {
        for (; p.x < changed.end.x; ++p.x) {
            const Vec3f b = *back++;
            if (b != Vec3f{0, 0, 0})
                visit(p, Vec3f{dot(rows[0], b), dot(rows[1], b), dot(rows[2], b)});
        }
    });
}

/// Likewise, for the elements that go to ijk + offset.
template <class Visit>
void for_targets(const WarpState& state, const Visit& visit) {
    const Box3i inside = overlap(state.box, voxel_box(state.grid));
    if (is_empty(inside)) return;
    const Vec3i n = state.box.end - state.box.begin;
    const std::size_t count = dense_count(n);
    const Vec3d h = state.grid.spacing_mm;
    const Vec3d per_unit{1 / (h.x * kUnitsPerMm), 1 / (h.y * kUnitsPerMm), 1 / (h.z * kUnitsPerMm)};
    for_each_row(inside, [&](Vec3i p) {
        const std::int32_t* u = state.units.data() + dense_index(p - state.box.begin, n);
        for (; p.x < inside.end.x; ++p.x, ++u) {
            const std::int32_t x = u[0], y = u[count], z = u[2 * count];
            if ((x | y | z) != 0)
                visit(p,
                      Vec3f{float(x * per_unit.x), float(y * per_unit.y), float(z * per_unit.z)});
        }
    });
}

/// Writes values of `from` to each voxel that visit_all visits.
template <class T, class VisitAll>
void write_labels(const Sampled<T>& from, LabelSampling sampling, const VisitAll& visit_all, T* to,
                  const Grid& grid) {
    if (sampling == LabelSampling::Nearest)
        visit_all(
            [&](Vec3i p, Vec3f offset) { to[voxel_index(grid, p)] = from.nearest(p, offset); });
    else
        visit_all(
            [&](Vec3i p, Vec3f offset) { to[voxel_index(grid, p)] = from.majority(p, offset); });
}

}  // namespace

template <class T>
void Warp::warp_image(std::span<const T> from, std::span<T> to, T beyond) const {
    std::copy(from.begin(), from.end(), to.begin());
    const Sampled<T> image(from.data(), grid().size, beyond);
    for_sources(grid(), m_changed, m_back.data(), [&](Vec3i p, Vec3f offset) {
        to[voxel_index(grid(), p)] = image.linear(p, offset);
    });
}

template <class T>
void Warp::warp_labels(std::span<const T> from, std::span<T> to, LabelSampling sampling,
                       T beyond) const {
    std::copy(from.begin(), from.end(), to.begin());
    const auto visit_all = [&](const auto& visit) {
        for_sources(grid(), m_changed, m_back.data(), visit);
    };
    write_labels({from.data(), grid().size, beyond}, sampling, visit_all, to.data(), grid());
}

template <class T>
void Warp::unwarp_image(std::span<const T> from, std::span<T> to, T beyond) const {
    std::copy(from.begin(), from.end(), to.begin());
    const Sampled<T> image(from.data(), grid().size, beyond);
    for_targets(m_state, [&](Vec3i p, Vec3f offset) {
        to[voxel_index(grid(), p)] = image.linear(p, offset);
    });
}

template <class T>
void Warp::unwarp_labels(std::span<const T> from, std::span<T> to, LabelSampling sampling,
                         T beyond) const {
    std::copy(from.begin(), from.end(), to.begin());
    const auto visit_all = [&](const auto& visit) { for_targets(m_state, visit); };
    write_labels({from.data(), grid().size, beyond}, sampling, visit_all, to.data(), grid());
}

#define PLIANT_WARP_OF(T)                                                                      \
    template void Warp::warp_image(std::span<const T>, std::span<T>, T) const;                 \
    template void Warp::warp_labels(std::span<const T>, std::span<T>, LabelSampling, T) const; \
    template void Warp::unwarp_image(std::span<const T>, std::span<T>, T) const;               \
    template void Warp::unwarp_labels(std::span<const T>, std::span<T>, LabelSampling, T) const;
PLIANT_WARP_OF(std::int8_t)
PLIANT_WARP_OF(std::int16_t)
PLIANT_WARP_OF(std::int32_t)
PLIANT_WARP_OF(std::int64_t)
PLIANT_WARP_OF(std::uint8_t)
PLIANT_WARP_OF(std::uint16_t)
PLIANT_WARP_OF(std::uint32_t)
PLIANT_WARP_OF(std::uint64_t)
PLIANT_WARP_OF(float)
PLIANT_WARP_OF(double)
#undef PLIANT_WARP_OF

}  // namespace pliant
