// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A warp's images and labels, there and back.

#include <pliant/data/warp.h>

#include <algorithm>
#include <array>

#include "field/fixed_point.h"
#include "volume/boxes.h"

namespace pliant {
namespace {

// Values between voxel centres of an array of any number type: trilinear, or a label.

/// Trilinear sums of wide integers and doubles are in double.
template <class T>
using SumOf = std::conditional_t<sizeof(T) < 4 || std::is_same_v<T, float>, float, double>;

template <class T>
T rounded_to(SumOf<T> value) {
    if constexpr (std::is_floating_point_v<T>) {
        return T(value);
    } else {
        using Limits = std::numeric_limits<T>;
        const auto nearest = std::floor(value + SumOf<T>(0.5));
        if (nearest <= SumOf<T>(Limits::min())) return Limits::min();
        if (nearest >= SumOf<T>(Limits::max())) return Limits::max();
        return T(nearest);
    }
}

/// An array with i fastest, and its value beyond the grid.
template <class T>
class Sampled {
  public:
    Sampled(const T* values, Vec3i size, T beyond)
        : m_values(values), m_size(size), m_beyond(beyond) {}

    /// Trilinear value at p + offset [voxels].
    T linear(Vec3i p, Vec3f offset) const {
        const Around around = look(p, offset);
        const auto along_x = [&](std::size_t n) {
            const auto low = SumOf<T>(around.values[n]), high = SumOf<T>(around.values[n + 1]);
            return low + around.fraction.x * (high - low);
        };
        const SumOf<T> a = along_x(0), b = along_x(2), c = along_x(4), d = along_x(6);
        const SumOf<T> low = a + around.fraction.y * (b - a);
        const SumOf<T> high = c + around.fraction.y * (d - c);
        return rounded_to<T>(low + around.fraction.z * (high - low));
    }

    T nearest(Vec3i p, Vec3f offset) const {
        return at({p.x + low_of(offset.x + 0.5f), p.y + low_of(offset.y + 0.5f),
                   p.z + low_of(offset.z + 0.5f)});
    }

    /// The value with the largest trilinear weight.
    T majority(Vec3i p, Vec3f offset) const {
        const Around around = look(p, offset);
        const auto& v = around.values;
        bool is_uniform = true;
        for (std::size_t n = 1; n < 8; ++n) is_uniform &= v[n] == v[0];
        if (is_uniform) return v[0];
        const auto weight = [&](std::size_t n) {
            const Vec3f f = around.fraction;
            return (n & 1 ? f.x : 1 - f.x) * (n & 2 ? f.y : 1 - f.y) * (n & 4 ? f.z : 1 - f.z);
        };
        T best = nearest(p, offset);
        float most = -1;
        for (std::size_t n = 0; n < 8; ++n) {
            float sum = 0;
            for (std::size_t m = 0; m < 8; ++m)
                if (v[m] == v[n]) sum += weight(m);
            if (sum > most || (sum == most && v[n] == nearest(p, offset))) {
                most = sum;
                best = v[n];
            }
        }
        return best;
    }

  private:
    struct Around {
        std::array<T, 8> values;  ///< x fastest
        Vec3f fraction;
    };

    static int low_of(float x) {
        const int whole = int(x);
        return whole - int(x < float(whole));
    }
    T at(Vec3i p) const {
        for (int a = 0; a < 3; ++a)
            if (p[a] < 0 || p[a] >= m_size[a]) return m_beyond;
        return m_values[index(p)];
    }
    std::size_t index(Vec3i p) const {
        return std::size_t(p.x) + std::size_t(m_size.x) *
                                      (std::size_t(p.y) + std::size_t(m_size.y) * std::size_t(p.z));
    }

    Around look(Vec3i p, Vec3f offset) const {
        const Vec3i low{low_of(offset.x), low_of(offset.y), low_of(offset.z)};
        Around around{{},
                      {offset.x - float(low.x), offset.y - float(low.y), offset.z - float(low.z)}};
        const Vec3i first = p + low;
        bool is_inside = true;
        for (int a = 0; a < 3; ++a) is_inside &= first[a] >= 0 && first[a] + 1 < m_size[a];
        if (is_inside) {
            const auto row = std::size_t(m_size.x), slice = row * std::size_t(m_size.y);
            const T* const v = m_values + index(first);
            around.values = {v[0],     v[1],         v[row],         v[row + 1],
                             v[slice], v[slice + 1], v[slice + row], v[slice + row + 1]};
            return around;
        }
        for (int n = 0; n < 8; ++n) {
            // A corner of weight 0 may lie beyond the grid.
            Vec3i corner = first;
            for (int a = 0; a < 3; ++a)
                if (around.fraction[a] > 0) corner[a] += n >> a & 1;
            around.values[std::size_t(n)] = at(corner);
        }
        return around;
    }

    const T* m_values;
    Vec3i m_size;
    T m_beyond;
};

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
