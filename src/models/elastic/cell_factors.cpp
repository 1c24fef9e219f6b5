// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "elastic/cell_factors.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

using Modes = std::array<std::array<double, 8>, 3>;

/// Forces for λ and μ, as in sweeps.inc.
Modes forces_of(const CellFactors& factors, double lambda, double mu, const Modes& w) {
    Modes f{};
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t m = 1; m < 8; ++m) f[a][m] = mu * double(factors.diagonal[a][m]) * w[a][m];
    for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t a = (c + 1) % 3, b = (c + 2) % 3;
        for (std::size_t n = 0; n < 2; ++n) {
            const std::size_t in_a = n << c | 1u << a, in_b = n << c | 1u << b;
            const double shear = mu * double(factors.shear[c][n]);
            f[a][in_b] += shear * w[b][in_a];
            f[b][in_a] += shear * w[a][in_b];
            if (n == 0) continue;
            const double stretch = mu * double(factors.stretch[c]);
            f[a][in_a] += stretch * w[b][in_b];
            f[b][in_b] += stretch * w[a][in_a];
        }
    }
    double pressure = 0;
    for (std::size_t a = 0; a < 3; ++a) pressure += double(factors.pressure[a]) * w[a][1u << a];
    for (std::size_t a = 0; a < 3; ++a)
        f[a][1u << a] += lambda * double(factors.pressure[a]) * pressure;
    return f;
}

int sign_of(std::size_t corner, std::size_t mode) {
    int sign = 1;
    for (std::size_t bit = 1; bit < 8; bit *= 2)
        if (mode & bit && !(corner & bit)) sign = -sign;
    return sign;
}

using Corners = std::array<double, 24>;  ///< 3c + a

Corners multiply(const CellFactors& factors, double lambda, double mu, const Corners& u) {
    Modes w{};
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t m = 0; m < 8; ++m)
            for (std::size_t c = 0; c < 8; ++c) w[a][m] += sign_of(c, m) * u[3 * c + a];
    const Modes f = forces_of(factors, lambda, mu, w);
    Corners out{};
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t c = 0; c < 8; ++c)
            for (std::size_t m = 0; m < 8; ++m) out[3 * c + a] += sign_of(c, m) * f[a][m];
    return out;
}

std::array<std::array<float, 6>, 8> blocks_of(const CellFactors& factors, double lambda,
                                              double mu) {
    std::array<std::array<float, 6>, 8> blocks{};
    for (std::size_t c = 0; c < 8; ++c)
        for (std::size_t a = 0, n = 0; a < 3; ++a) {
            Corners unit{};
            unit[3 * c + a] = 1;
            const Corners f = multiply(factors, lambda, mu, unit);
            for (std::size_t b = a; b < 3; ++b) blocks[c][n++] = float(f[3 * c + b]);
        }
    return blocks;
}

}  // namespace

CellFactors cell_factors(Vec3d h) {
    CellFactors factors{};
    const double volume = h.x * h.y * h.z;
    double k[3];
    for (int a = 0; a < 3; ++a) {
        k[a] = 1 / (4 * h[a]);
        factors.pressure[a] = float(std::sqrt(volume) * k[a]);
        factors.gradient[a] = float(k[a]);
        factors.rest[a] = float(4 * h[a]);
    }
    // ∫ ξ^m ξ^m over the cell.
    const auto weight = [&](int m) {
        return volume / (m & 1 ? 3 : 1) / (m & 2 ? 3 : 1) / (m & 4 ? 3 : 1);
    };
    for (int a = 0; a < 3; ++a)
        for (int m = 1; m < 8; ++m) {
            double sum = 0;
            for (int b = 0; b < 3; ++b)
                if (m >> b & 1) sum += weight(m & ~(1 << b)) * k[b] * k[b];
            // ∂_a u_a twice, less a third of its square; λ has the latter in the linear mode.
            const double twice = m == 1 << a ? 1 : 1.0 / 3;
            if (m >> a & 1) sum += twice * weight(m & ~(1 << a)) * k[a] * k[a];
            factors.diagonal[a][m] = float(sum);
        }
    for (int c = 0; c < 3; ++c) {
        const double across = k[(c + 1) % 3] * k[(c + 2) % 3];
        factors.shear[c][0] = float(volume * across);
        factors.shear[c][1] = float(volume / 3 * across);
        factors.stretch[c] = float(-2.0 / 3 * volume / 3 * across);
    }
    return factors;
}

CornerBlocks corner_blocks(const CellFactors& factors) {
    return {blocks_of(factors, 1, 0), blocks_of(factors, 0, 1)};
}

double cell_spectrum(const CellFactors& factors, double lambda_per_mu) {
    constexpr int kTurns = 200;
    constexpr double kSafety = 1.02;
    const auto blocks = blocks_of(factors, lambda_per_mu, 1);
    Corners x{};
    for (std::size_t n = 0; n < 24; ++n) x[n] = std::sin(1 + 2.7 * double(n));
    double bound = 0;
    for (int turn = 0; turn < kTurns; ++turn) {
        const Corners y = multiply(factors, lambda_per_mu, 1, x);
        double numerator = 0, denominator = 0, largest = 0;
        for (std::size_t c = 0; c < 8; ++c) {
            const auto& d = blocks[c];
            const Mat3d block{
                {Vec3d{d[0], d[1], d[2]}, Vec3d{d[1], d[3], d[4]}, Vec3d{d[2], d[4], d[5]}}};
            const Vec3d z = inverse(block) * Vec3d{y[3 * c], y[3 * c + 1], y[3 * c + 2]};
            for (int a = 0; a < 3; ++a) {
                const std::size_t n = 3 * c + std::size_t(a);
                numerator += z[a] * y[n];
                denominator += x[n] * y[n];
                x[n] = z[a];
                largest = std::max(largest, std::abs(z[a]));
            }
        }
        bound = numerator / denominator;
        for (double& value : x) value /= largest;
    }
    return kSafety * bound;
}

}  // namespace pliant
