// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Conversion of a line integral to a grey value: quantum noise, characteristic curve and
// collimator. The page's shader (viewer/src/shaders/fluoroscopy.frag.glsl) computes the same; the
// hash is bit-identical.
//
// A detector counts N photons, N = N₀ exp(−p) on average with a standard deviation of √N. The
// logarithm p then has the standard deviation 1/√N = σ₀ exp((p − p₀)/2): dark regions are noisier.
// A photon's light spreads to neighbouring pixels, so a detector's noise is correlated. Correlation
// and a nearly normal distribution both come from one sum over a pixel's four corners, each with an
// independent number in 0…1:
//
//      u00 ─── u10
//       │ pixel │      n = √3 (u00 + u10 + u01 + u11 − 2),   mean 0, variance 1
//      u01 ─── u11

#pragma once

#include <pliant/render.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "render/camera.h"

namespace pliant::render {

/// Standard deviation of the line integral at 45 % grey with a noise factor of 1: 400 photons per
/// pixel.
inline constexpr double kQuantumNoise = 0.05;
inline constexpr double kNoisiest = 4;                ///< maximum factor in dark regions
inline constexpr double kMedianOdds = 0.55 / 0.45;    ///< ratio of black to white at 45 % grey
inline constexpr double kCurveWindow = 4;             ///< width of the curve, in line integral
inline constexpr double kBlade = 0.975, kOpen = 1.0;  ///< the collimator's soft edge [radii]

/// Random number of a pixel's corner, uniform in 0…1 in steps of 2⁻²⁴.
inline double corner_noise(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
    std::uint32_t h = x * 0x8da6b343U ^ y * 0xd8163841U ^ seed * 0xcb1ab31fU;
    h = (h + 1) * 0x9e3779b1U;
    h = (h ^ (h >> 16)) * 0x85ebca6bU;
    h = (h ^ (h >> 13)) * 0xc2b2ae35U;
    h ^= h >> 16;
    return double(h >> 8) / 16777216.0;
}

/// Noise of a pixel: mean 0, variance 1, correlation 1/2 with a neighbour.
/// @param x, y  pixel, from the top left corner
inline double pixel_noise(int x, int y, std::uint32_t seed) {
    const auto i = std::uint32_t(x), j = std::uint32_t(y);
    const double sum = corner_noise(i, j, seed) + corner_noise(i + 1, j, seed) +
                       corner_noise(i, j + 1, seed) + corner_noise(i + 1, j + 1, seed);
    return std::numbers::sqrt3 * (sum - 2);
}

/// Standard deviation of a line integral. @param excess  over the exposure
inline double quantum_noise(double excess) {
    return kQuantumNoise * std::min(std::exp(excess / 2), kNoisiest);
}

/// Share of white. @param excess  contrast · line integral, over that of the exposure
inline double curve(double excess) {
    return 1 / (1 + kMedianOdds * std::exp(4 * excess / kCurveWindow));
}

/// Share of light that the collimator transmits. @param u, v  position in the picture [halves of
/// its height, from its centre]
inline double collimator(FieldStop stop, double aspect, double u, double v) {
    const double radius = std::min(1.0, aspect);
    u = std::abs(u) / radius;
    v = std::abs(v) / radius;
    const double away = stop == FieldStop::Round ? std::sqrt(u * u + v * v)
                        : stop == FieldStop::Octagon
                            ? std::max({u, v, (u + v) * std::numbers::sqrt2 / 2})
                            : 0;
    const double s = std::clamp((away - kBlade) / (kOpen - kBlade), 0.0, 1.0);
    return 1 - s * s * (3 - 2 * s);
}

/// Camera of the X-ray source, with the detector as its picture.
Endoscope x_ray_source(const Fluoroscopy& settings, int width, int height);
/// Median over a grid of rays through the central third of the picture, without rays that miss the
/// scan [mm of water]; 0 if all miss.
double metered_water_mm(const Volume& scan, const Fluoroscopy& settings, int width, int height);
/// Grey value of a pixel, with noise and collimator.
std::uint8_t detected(const Fluoroscopy& settings, const Camera& camera, int x, int y,
                      double water_mm, double exposure_mm);

}  // namespace pliant::render
