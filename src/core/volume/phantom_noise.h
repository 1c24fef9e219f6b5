// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Noise and random numbers for phantoms from an integer hash: identical on every machine, and
// defined in the world, so that a finer grid shows the same tissue.

#pragma once

#include "volume/phantom_shapes.h"

#include <cmath>
#include <cstdint>

namespace pliant::phantom {

/// Hashes a lattice point to 32 bits.
inline std::uint32_t hash_bits(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
    std::uint64_t h = seed * 0x9e3779b97f4a7c15ULL;
    h ^= std::uint64_t(x) * 0x8cb92ba72f3d8dd7ULL;
    h ^= std::uint64_t(y) * 0xd6e8feb86659fd93ULL;
    h ^= std::uint64_t(z) * 0xa0761d6478bd642fULL;
    h = (h ^ (h >> 32)) * 0xd6e8feb86659fd93ULL;
    h = (h ^ (h >> 32)) * 0x9e3779b97f4a7c15ULL;
    return std::uint32_t(h >> 32);
}

/// Smooth noise in −1…1 with one random value per lattice point of p.
inline double value_noise(Vec3d p, std::uint64_t seed) {
    const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
    const auto fade = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
    const double u = fade(p.x - fx), v = fade(p.y - fy), w = fade(p.z - fz);
    const auto x = std::int64_t(fx), y = std::int64_t(fy), z = std::int64_t(fz);
    const auto at = [&](int dx, int dy, int dz) {
        return double(hash_bits(x + dx, y + dy, z + dz, seed)) * (2.0 / 4294967295.0) - 1.0;
    };
    const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
    const double near = mix(mix(at(0, 0, 0), at(1, 0, 0), u), mix(at(0, 1, 0), at(1, 1, 0), u), v);
    const double far = mix(mix(at(0, 0, 1), at(1, 0, 1), u), mix(at(0, 1, 1), at(1, 1, 1), u), v);
    return mix(near, far, w);
}

/// Sequence of random numbers.
class Chance {
  public:
    explicit Chance(std::uint64_t seed) : m_seed(seed) {}
    /// Uniform between low and high.
    double between(double low, double high) {
        return low + (high - low) * double(hash_bits(++m_count, 0, 0, m_seed)) / 4294967295.0;
    }
    /// Uniform in a cube around 0 of half-width 1.
    Vec3d vector() {
        const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
        return {x, y, z};
    }

  private:
    std::uint64_t m_seed;
    std::int64_t m_count = 0;
};

/// Constant value [HU].
inline ScalarField uniform(double hu) {
    return [hu](Vec3d) { return hu; };
}
/// A value [HU] with fine scanner noise and coarser mottle of the tissue.
inline ScalarField tissue(double hu, double grain_hu, double mottle_hu = 0, double mottle_mm = 4) {
    return [=](Vec3d p) {
        double value = hu;
        if (grain_hu > 0) value += grain_hu * value_noise(p * (1 / 1.3), 11);
        if (mottle_hu > 0) value += mottle_hu * value_noise(p * (1 / mottle_mm), 12);
        return value;
    };
}

}  // namespace pliant::phantom
