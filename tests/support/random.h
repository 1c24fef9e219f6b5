// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Random numbers for tests: the same on every machine, and the seed is printed on failure.

#pragma once

#include <pliant/core/vec.h>

#include <cstdint>

namespace pliant::test {

/// SplitMix64 [Steele2014].
class Random {
  public:
    explicit Random(std::uint64_t seed) : m_state(seed) {}

    std::uint64_t next() {
        std::uint64_t z = (m_state += 0x9e3779b97f4a7c15ULL);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
        return z ^ (z >> 31);
    }
    /// Whole number low…high.
    int whole(int low, int high) { return low + int(next() % std::uint64_t(high - low + 1)); }
    double real(double low, double high) {
        return low + (high - low) * (double(next() >> 11) * 0x1p-53);
    }
    /// Evenly spread over the logarithm.
    double ratio(double low, double high) {
        return low * std::exp(real(0, 1) * std::log(high / low));
    }
    Vec3d vector(double length) {
        return {real(-length, length), real(-length, length), real(-length, length)};
    }
    /// A rotation by a random angle about each axis; left-handed if mirrored.
    Mat3d rotation(bool mirrored) {
        Mat3d m = kIdentity3;
        for (int a = 0; a < 3; ++a) {
            const double t = real(-3, 3), c = std::cos(t), s = std::sin(t);
            Mat3d r = kIdentity3;
            r.columns[(a + 1) % 3][(a + 1) % 3] = c;
            r.columns[(a + 1) % 3][(a + 2) % 3] = s;
            r.columns[(a + 2) % 3][(a + 1) % 3] = -s;
            r.columns[(a + 2) % 3][(a + 2) % 3] = c;
            m = m * r;
        }
        if (mirrored) m.columns[2] = -m.columns[2];
        return m;
    }

  private:
    std::uint64_t m_state;
};

}  // namespace pliant::test
