// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Random numbers by counter: number n of a stream depends on the seed, the stream and n alone. The
// mixing step is SplitMix64's [Steele2014].

#pragma once

#include <pliant/core/vec.h>

#include <cstdint>

namespace pliant::truth {

inline std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

class Draws {
  public:
    Draws(std::uint64_t seed, std::uint64_t stream)
        : m_key(mixed(mixed(seed + kStep) ^ (kStep * (stream + 1)))) {}

    std::uint64_t bits() { return mixed(m_key + kStep * ++m_count); }
    /// 0 ≤ number < 1
    double unit() { return double(bits() >> 11) * 0x1p-53; }
    double real(double low, double high) { return low + (high - low) * unit(); }
    /// 0 ≤ number < count. @pre count > 0
    std::uint64_t below(std::uint64_t count) { return bits() % count; }
    /// Evenly spread over the sphere.
    Vec3d direction() {
        for (;;) {
            const Vec3d v{real(-1, 1), real(-1, 1), real(-1, 1)};
            const double length = norm(v);
            if (length > 0.1 && length <= 1) return (1 / length) * v;
        }
    }
    /// A direction perpendicular to a unit vector.
    Vec3d across(Vec3d unit_vector) {
        for (;;) {
            const Vec3d v = direction();
            const Vec3d flat = v - dot(v, unit_vector) * unit_vector;
            if (norm(flat) > 0.1) return normalized(flat);
        }
    }

  private:
    static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ULL;
    std::uint64_t m_key, m_count = 0;
};

}  // namespace pliant::truth
