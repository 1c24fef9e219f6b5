// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rounded limits as plain loops: the readable twin of rounded_vector.cpp.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "propagate/rounded_kernel.h"

namespace pliant {
namespace {

/// The neighbours of one element, by side: −x, +x, −y, +y, −z, +z.
struct RoundedLinks {
    std::array<Fixed, 6> lag;     ///< largest lag of the element behind each
    std::array<double, 6> share;  ///< 1/lag; 0 where the link does not count

    void set(std::size_t side, Fixed link_lag) {
        lag[side] = link_lag;
        share[side] = share_of_unit(link_lag);
    }
};

/// Shares of lag on each axis, before squaring, for an element at v.
inline Vec3d lag_shares(const RoundedLinks& links, const std::array<Fixed, 6>& w, Fixed v) {
    Vec3d shares{};
    for (int b = 0; b < 3; ++b) {
        const auto low = std::size_t(2 * b), high = low + 1;
        const double below = (double(w[low]) - v) * links.share[low];
        const double above = (double(w[high]) - v) * links.share[high];
        shares[b] = std::max(0.0, std::max(below, above));
    }
    return shares;
}

inline double lag_sum(const RoundedLinks& links, const std::array<Fixed, 6>& w, Fixed v) {
    const Vec3d t = lag_shares(links, w, v);
    return t.x * t.x + t.y * t.y + t.z * t.z;
}

/// Lower bound of the rise from v at which the sum falls to the bound: the root of
/// Σ (t_b − q_b·x)² = bound over the axes that still contribute there. Neighbours that become the
/// largest of their axis on the way are ignored, so it may fall short.
/// @pre the sum at v is above the bound
inline double rounded_rise(const RoundedLinks& links, const std::array<Fixed, 6>& w, double bound,
                           Fixed v) {
    const Vec3d t = lag_shares(links, w, v);
    Vec3d q{};
    for (int b = 0; b < 3; ++b) {
        const auto low = std::size_t(2 * b), high = low + 1;
        const bool is_low = (double(w[low]) - v) * links.share[low] == t[b];
        q[b] = t[b] > 0 ? links.share[is_low ? low : high] : 0;
    }
    for (;;) {
        double qq = 0, qt = 0, tt = 0;
        int nearest = -1;  // the axis that ceases to contribute first
        for (int b = 0; b < 3; ++b) {
            if (q[b] == 0) continue;
            qq += q[b] * q[b];
            qt += q[b] * t[b];
            tt += t[b] * t[b];
            if (nearest < 0 || t[b] * q[nearest] < t[nearest] * q[b]) nearest = b;
        }
        const double under_root = qt * qt - qq * (tt - bound);
        const double rise =
            under_root >= 0 ? (tt - bound) / (qt + std::sqrt(under_root)) : HUGE_VAL;
        if (nearest < 0 || rise * q[nearest] <= t[nearest]) return nearest < 0 ? 0 : rise;
        q[nearest] = 0;
    }
}

/// Least position at or above v that satisfies every link's lag and the bound of the sum.
/// @pre bound ≥ 1
inline Fixed least_rounded_position(const RoundedLinks& links, const std::array<Fixed, 6>& w,
                                    double bound, Fixed v) {
    for (std::size_t s = 0; s < 6; ++s) v = std::max(v, w[s] - links.lag[s]);
    if (!(lag_sum(links, w, v) > bound)) return v;
    const Fixed lowest = v;
    do {
        const double rise = rounded_rise(links, w, bound, v);
        v += std::max(Fixed(1), Fixed(std::min(rise, double(kMaxHalfLimit))));
    } while (lag_sum(links, w, v) > bound);
    // The guess is only a start: the result is the crossing of the sum itself.
    while (v > lowest && !(lag_sum(links, w, v - 1) > bound)) --v;
    return v;
}

/// A brick's elements with one layer of neighbours around them.
class Halo {
  public:
    void load(const RoundedBrick& brick) {
        m_size = brick.size;
        m_row = m_size + 2;
        const auto all = std::size_t(m_row) * std::size_t(m_row) * std::size_t(m_row);
        const auto own = std::size_t(m_size) * std::size_t(m_size) * std::size_t(m_size);
        m_now.assign(all, kNeverLeads);
        m_start.assign(all, brick.start ? kNeverLeads : 0);
        m_waiting.assign(all, char(brick.is_new));
        m_links.resize(own);
        m_bound.resize(own);
        for_each_own([&](Vec3i local, std::size_t n) {
            m_now[index(local)] = brick.w[n];
            if (brick.start) m_start[index(local)] = brick.start[n];
            for (int b = 0; b < 3; ++b) link_inside(brick, local, n, b);
        });
        for (int side = 0; side < 6; ++side) load_face(brick, side);
        for_each_own([&](Vec3i local, std::size_t n) {
            const auto before = around(m_start, index(local));
            m_bound[n] = std::max(1.0, lag_sum(m_links[n], before, m_start[index(local)]));
        });
    }

    /// One pass over the waiting elements, in one of the eight orders of the axes' directions: one
    /// of them follows a motion from any origin. @returns whether anything rose
    bool sweep(unsigned order) {
        bool changed = false;
        const int last = m_size - 1;
        const auto position = [&](int k, int axis) { return order >> axis & 1 ? last - k : k; };
        for (int k = 0; k < m_size; ++k)
            for (int j = 0; j < m_size; ++j) {
                const int y = position(j, 1), z = position(k, 2);
                const std::size_t first = index({0, y, z});
                const std::size_t own = std::size_t(m_size) * std::size_t(y + m_size * z);
                for (int i = 0; i < m_size; ++i) {
                    const auto x = std::size_t(position(i, 0));
                    if (!m_waiting[first + x]) continue;
                    m_waiting[first + x] = 0;
                    changed |= update(first + x, own + x);
                }
            }
        return changed;
    }

    void store(Fixed* w) const {
        for_each_own([&](Vec3i local, std::size_t n) { w[n] = m_now[index(local)]; });
    }

  private:
    std::size_t index(Vec3i local) const {
        return std::size_t(local.x + 1 + m_row * (local.y + 1 + m_row * (local.z + 1)));
    }
    int stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? m_row : m_row * m_row; }
    std::array<Fixed, 6> around(const std::vector<Fixed>& w, std::size_t n) const {
        const Fixed* here = w.data() + n;
        const int y = m_row, z = m_row * m_row;
        return {here[-1], here[1], here[-y], here[y], here[-z], here[z]};
    }
    template <class Visit>
    void for_each_own(const Visit& visit) const {
        for (int z = 0, n = 0; z < m_size; ++z)
            for (int y = 0; y < m_size; ++y)
                for (int x = 0; x < m_size; ++x, ++n) visit(Vec3i{x, y, z}, std::size_t(n));
    }

    /// The link from an element to the next one along an axis.
    void link_inside(const RoundedBrick& brick, Vec3i local, std::size_t n, int axis) {
        if (local[axis] + 1 == m_size) return;
        const auto b = std::size_t(axis);
        const int step = axis == 0 ? 1 : axis == 1 ? m_size : m_size * m_size;
        m_links[n].set(2 * b + 1, brick.lags.backward[b][n]);
        m_links[n + std::size_t(step)].set(2 * b, brick.lags.forward[b][n]);
    }

    void load_face(const RoundedBrick& brick, int side) {
        const RoundedBrick::Face& face = brick.faces[std::size_t(side)];
        const int axis = side / 2, p_axis = axis == 0, q_axis = axis == 2 ? 1 : 2;
        Vec3i local{0, 0, 0};
        local[axis] = side % 2 ? m_size - 1 : 0;
        for (int q = 0, n = 0; q < m_size; ++q)
            for (int p = 0; p < m_size; ++p, ++n) {
                local[p_axis] = p, local[q_axis] = q;
                const auto own = std::size_t(local.x + m_size * (local.y + m_size * local.z));
                m_links[own].set(std::size_t(side), face.now ? face.lag[n] : kUnlinked);
                if (!face.now) continue;
                const std::size_t at = index(local);
                const auto step = std::size_t(stride(axis));
                const std::size_t behind = side % 2 ? at + step : at - step;
                m_now[behind] = face.now[n];
                if (brick.start) m_start[behind] = face.start[n];
                if (face.rose && face.now[n] > m_now[at]) m_waiting[at] = 1;
            }
    }

    /// Updates one element. @returns whether it rose; its neighbours then need an update
    bool update(std::size_t at, std::size_t n) {
        const auto w = around(m_now, at);
        Fixed& here = m_now[at];
        if (*std::max_element(w.begin(), w.end()) <= here) return false;
        const Fixed raised = least_rounded_position(m_links[n], w, m_bound[n], here);
        if (raised == here) return false;
        here = raised;
        for (int b = 0; b < 3; ++b) {
            const auto step = std::size_t(stride(b));
            m_waiting[at - step] = m_waiting[at + step] = 1;
        }
        return true;
    }

    int m_size = 0, m_row = 0;
    std::vector<Fixed> m_start;         ///< before the push
    std::vector<Fixed> m_now;           ///< raised so far
    std::vector<RoundedLinks> m_links;  ///< of the brick's own elements
    std::vector<double> m_bound;
    std::vector<char> m_waiting;  ///< whether a neighbour rose since the last update
};

void relax(const RoundedBrick& brick) {
    static thread_local Halo halo;
    halo.load(brick);
    // Opposite orders alternate.
    constexpr std::array<unsigned, 8> kOrders = {0, 7, 1, 6, 2, 5, 3, 4};
    for (std::size_t n = 0; halo.sweep(kOrders[n % kOrders.size()]); ++n) {
    }
    halo.store(brick.w);
}

}  // namespace

RelaxRounded plain_relax_rounded() {
    return relax;
}

}  // namespace pliant
