// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/noise_tile.h"

#include <cmath>

namespace pliant::render {
namespace {

/// Value of a lattice point: uniform in 0…1, nine bits.
double lattice_value(int x, int y, int z) {
    const auto wrapped = [](int i) { return std::uint32_t(i & (NoiseTile::kCells - 1)); };
    std::uint32_t h = wrapped(x) | wrapped(y) << 4 | wrapped(z) << 8;
    h = (h + 1) * 0x9E3779B1u;  // multiply and shift, as in the finaliser of MurmurHash3
    h = (h ^ h >> 16) * 0x85EBCA6Bu;
    h = (h ^ h >> 13) * 0xC2B2AE35u;
    h ^= h >> 16;
    return (double(h >> 24) + 0.5) / 256;
}

/// 3f² − 2f³: weight of the upper neighbour at a fraction f of the cell; then its slope.
constexpr double fade(double f) {
    return f * f * (3 - 2 * f);
}
constexpr double fade_slope(double f) {
    return 6 * f * (1 - f);
}

NoiseTile::Value bake(int i, int j, int k) {
    const int cell[3] = {i / 4, j / 4, k / 4};
    const double f[3] = {i % 4 / 4.0, j % 4 / 4.0, k % 4 / 4.0};
    double value = 0, slope[3] = {0, 0, 0};
    for (int corner = 0; corner < 8; ++corner) {
        const int up[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
        const double own = lattice_value(cell[0] + up[0], cell[1] + up[1], cell[2] + up[2]);
        double weight[3], change[3];
        for (int a = 0; a < 3; ++a) {
            weight[a] = up[a] ? fade(f[a]) : 1 - fade(f[a]);
            change[a] = up[a] ? fade_slope(f[a]) : -fade_slope(f[a]);
        }
        value += own * weight[0] * weight[1] * weight[2];
        slope[0] += own * change[0] * weight[1] * weight[2];
        slope[1] += own * weight[0] * change[1] * weight[2];
        slope[2] += own * weight[0] * weight[1] * change[2];
    }
    return {{float(slope[0]), float(slope[1]), float(slope[2])}, float(value)};
}

}  // namespace

NoiseTile::NoiseTile() {
    m_samples.reserve(std::size_t(kSamples) * kSamples * kSamples);
    for (int k = 0; k < kSamples; ++k)
        for (int j = 0; j < kSamples; ++j)
            for (int i = 0; i < kSamples; ++i) m_samples.push_back(bake(i, j, k));
}

const NoiseTile& NoiseTile::instance() {
    static const NoiseTile tile;
    return tile;
}

NoiseTile::Value NoiseTile::at(Vec3d q) const {
    std::size_t low[3], high[3];
    float f[3];
    for (int a = 0; a < 3; ++a) {
        const double position = q[a] * (kSamples / kCells), whole = std::floor(position);
        f[a] = float(position - whole);
        low[a] = std::size_t(std::int64_t(whole) & (kSamples - 1));
        high[a] = (low[a] + 1) & (kSamples - 1);
    }
    const auto row = [&](std::size_t y, std::size_t z) {
        const std::size_t begin = (z * kSamples + y) * kSamples;
        const Value &a = m_samples[begin + low[0]], &b = m_samples[begin + high[0]];
        return Value{a.slope + f[0] * (b.slope - a.slope), a.value + f[0] * (b.value - a.value)};
    };
    const auto mix = [](const Value& a, const Value& b, float s) {
        return Value{a.slope + s * (b.slope - a.slope), a.value + s * (b.value - a.value)};
    };
    return mix(mix(row(low[1], low[2]), row(high[1], low[2]), f[1]),
               mix(row(low[1], high[2]), row(high[1], high[2]), f[1]), f[2]);
}

}  // namespace pliant::render
