// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Values between voxel centres of an array of any number type: trilinear, or a label.

#pragma once

#include <pliant/data/warp.h>

#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

namespace pliant {

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

}  // namespace pliant
