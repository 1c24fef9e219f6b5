// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// An independent oracle: the closed form of the minimal move, by brute force on a dense grid.
//
//   u'(j) = min( max( u(j), max_s(U_s − d⁻(s,j)) ), min_s(U_s + d⁺(s,j)) )
//
// The two envelopes are relaxed over all links, again and again, until nothing changes
// [Bellman1958]. The oracle shares no code with the solvers, and works on doubles with the law's
// own limits, or on integers with limits rounded as the lattice promises to round them.

#pragma once

#include <pliant/chainmail.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

namespace pliant::test {

/// T = double: millimetres. T = std::int64_t: units of 2⁻²⁰ mm.
template <class T>
class Oracle {
  public:
    /// The grid reaches `margin` elements of air beyond the volume on every side.
    Oracle(const Volume& volume, const MaterialLaw& law, int margin)
        : Oracle(
              volume.grid,
              [&](Vec3i e) {
                  const bool inside = contains(voxel_box(volume.grid), e);
                  return law(inside ? int(volume.at(e)) : kAirHu);
              },
              margin) {}

    /// A separate law for each element.
    Oracle(const Grid& grid, const std::function<ElementLimits(Vec3i)>& limits_at, int margin)
        : m_grid(grid), m_margin(margin) {
        m_size = m_grid.size + Vec3i{2 * margin, 2 * margin, 2 * margin};
        const auto n = std::size_t(m_size.x) * std::size_t(m_size.y) * std::size_t(m_size.z);
        m_limits.reserve(n);
        for (int z = 0; z < m_size.z; ++z)
            for (int y = 0; y < m_size.y; ++y)
                for (int x = 0; x < m_size.x; ++x) {
                    const Vec3i e = Vec3i{x, y, z} - Vec3i{margin, margin, margin};
                    m_limits.push_back(limits_at(e));
                }
        for (auto& u : m_u) u.assign(n, 0);
        for (auto& cut : m_cut) cut.assign(n, false);
        m_edits.assign(n, 0);
        for (std::size_t b = 0; b < 3; ++b)
            for (const ElementLimits& limits : m_limits) {
                m_compress[b].push_back(half(limits.compress[int(b)], int(b)));
                m_stretch[b].push_back(half(limits.stretch[int(b)], int(b)));
                m_shear[b].push_back(half(limits.shear[int(b)], int(b)));
            }
    }

    std::size_t index(Vec3i e) const {
        const Vec3i p = e + Vec3i{m_margin, m_margin, m_margin};
        return std::size_t(p.x) + std::size_t(m_size.x) *
                                      (std::size_t(p.y) + std::size_t(m_size.y) * std::size_t(p.z));
    }
    T displacement(Vec3i e, int axis) const { return m_u[std::size_t(axis)][index(e)]; }
    const ElementLimits& limits(Vec3i e) const { return m_limits[index(e)]; }

    /// Removes the link from an element to its neighbour at +axis.
    void cut(Vec3i e, int axis) { m_cut[std::size_t(axis)][index(e)] = true; }
    /// Removes all links of an element.
    void carve(Vec3i e) {
        for (int axis = 0; axis < 3; ++axis) {
            cut(e, axis);
            Vec3i low = e;
            low[axis] -= 1;
            if (low[axis] >= -m_margin) cut(low, axis);
        }
    }
    /// Links outside of their limits before a push may stay there, and must not get worse.
    void set_may_exceed_limits(bool may) { m_may_exceed = may; }
    void place(Vec3i e, int axis, T u) { m_u[std::size_t(axis)][index(e)] = u; }
    /// Flags like the lattice's: 1, 2, 4: the link to the neighbour at +x, +y, +z is cut; 8: the
    /// element is void, and has no links.
    void set_edits(Vec3i e, std::uint8_t flags) {
        m_edits[index(e)] = flags;
        if (flags & 8)
            for (auto& u : m_u) u[index(e)] = 0;
    }

    /// Elements of the grid, margin included.
    template <class Visit>
    void for_each(const Visit& visit) const {
        for (int z = -m_margin; z < m_grid.size.z + m_margin; ++z)
            for (int y = -m_margin; y < m_grid.size.y + m_margin; ++y)
                for (int x = -m_margin; x < m_grid.size.x + m_margin; ++x) visit(Vec3i{x, y, z});
    }

    /// Shifts the elements of S together by `shift` (along the lattice's axes).
    void push(std::span<const Vec3i> s, Vec3<T> shift) {
        for (int axis = 0; axis < 3; ++axis) push_component(s, axis, shift[axis]);
    }

    /// Whether the outermost layer of the margin has not moved: the grid was then large enough.
    bool margin_at_rest() const {
        bool rest = true;
        for_each([&](Vec3i e) {
            bool border = false;
            for (int a = 0; a < 3; ++a)
                border |= e[a] == -m_margin || e[a] == m_grid.size[a] + m_margin - 1;
            if (border)
                for (int a = 0; a < 3; ++a) rest &= displacement(e, a) == 0;
        });
        return rest;
    }

  private:
    T half(double fraction, int b) const {
        const double mm = m_grid.spacing_mm[b] * fraction / 2;
        if constexpr (std::is_integral_v<T>) return T(std::floor(mm * (1 << 20)));
        return T(mm);
    }
    void push_component(std::span<const Vec3i> s, int axis, T shift) {
        auto& u = m_u[std::size_t(axis)];
        std::vector<T> lower(u.size(), -kFar), upper(u.size(), kFar);
        for (const Vec3i& e : s) lower[index(e)] = upper[index(e)] = u[index(e)] + shift;
        const std::array<Links, 3> links = {links_along(0, axis), links_along(1, axis),
                                            links_along(2, axis)};
        // Alternating sweeps, so that a change doesn't need one sweep per link.
        for (bool changed = true, backwards = false; changed; backwards = !backwards) {
            changed = false;
            for (int b = 0; b < 3; ++b)
                changed |= relax_links(links[std::size_t(b)], b, backwards, lower, upper);
        }
        for (std::size_t n = 0; n < u.size(); ++n)
            u[n] = std::min(std::max(u[n], lower[n]), upper[n]);
    }

    /// Largest u(j) − u(i) of the link from i up to j, and its negative counterpart, by i. kFar
    /// without a link.
    struct Links {
        std::vector<T> up, down;
    };
    std::size_t step_along(int b) const {
        return b == 0   ? 1
               : b == 1 ? std::size_t(m_size.x)
                        : std::size_t(m_size.x) * std::size_t(m_size.y);
    }
    Links links_along(int b, int axis) const {
        const std::size_t step = step_along(b);
        const auto& most = axis == b ? m_stretch[std::size_t(b)] : m_shear[std::size_t(b)];
        const auto& least = axis == b ? m_compress[std::size_t(b)] : m_shear[std::size_t(b)];
        const auto& u = m_u[std::size_t(axis)];
        Links links{std::vector<T>(u.size(), kFar), std::vector<T>(u.size(), kFar)};
        for (std::size_t i = 0, j = step; j < u.size(); ++i, ++j) {
            if ((m_edits[i] & (8 | 1 << b)) || (m_edits[j] & 8)) continue;
            if (m_cut[std::size_t(b)][i]) continue;
            links.up[i] = most[i] + most[j];
            links.down[i] = least[i] + least[j];
            if (!m_may_exceed) continue;
            links.up[i] = std::max(links.up[i], u[j] - u[i]);
            links.down[i] = std::max(links.down[i], u[i] - u[j]);
        }
        return links;
    }

    bool relax_links(const Links& links, int b, bool backwards, std::vector<T>& lower,
                     std::vector<T>& upper) const {
        const std::size_t step = step_along(b);
        const Vec3i count = m_size - Vec3i{b == 0, b == 1, b == 2};
        // Branch-free, to avoid mispredictions.
        const auto relax = [&](std::size_t i) {
            const std::size_t j = i + step;
            const T up = links.up[i], down = links.down[i];
            const T lower_i = lower[i], lower_j = lower[j], upper_i = upper[i], upper_j = upper[j];
            const T raised_j = std::max(lower_j, lower_i - down);
            const T raised_i = std::max(lower_i, raised_j - up);
            const T lowered_j = std::min(upper_j, upper_i + up);
            const T lowered_i = std::min(upper_i, lowered_j + down);
            lower[j] = raised_j, lower[i] = raised_i, upper[j] = lowered_j, upper[i] = lowered_i;
            return (raised_j != lower_j) | (raised_i != lower_i) | (lowered_j != upper_j) |
                   (lowered_i != upper_i);
        };
        const Vec3i first{-m_margin, -m_margin, -m_margin};
        bool changed = false;
        for (int row = 0; row < count.y * count.z; ++row) {
            const int at = backwards ? count.y * count.z - 1 - row : row;
            const std::size_t from = index(first + Vec3i{0, at % count.y, at / count.y});
            const auto length = std::size_t(count.x);
            if (backwards)
                for (std::size_t x = length; x-- > 0;) changed |= relax(from + x);
            else
                for (std::size_t x = 0; x < length; ++x) changed |= relax(from + x);
        }
        return changed;
    }

    /// Above all sums of limits; twice the value is still finite.
    static constexpr T kFar = std::numeric_limits<T>::max() / 4;

    Grid m_grid;
    int m_margin;
    Vec3i m_size;
    std::vector<ElementLimits> m_limits;
    std::array<std::vector<T>, 3> m_compress, m_stretch, m_shear;  ///< halves, by link axis
    std::array<std::vector<T>, 3> m_u;
    std::array<std::vector<bool>, 3> m_cut;  ///< [lower element of the link]
    bool m_may_exceed = false;
    std::vector<std::uint8_t> m_edits;
};

}  // namespace pliant::test
