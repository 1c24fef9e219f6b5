// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Light is summed in linear red, green and blue, 0…1; pictures are stored in sRGB.

#pragma once

#include <pliant/render.h>

#include <algorithm>
#include <cmath>

namespace pliant::render {

inline double linear_from_srgb(std::uint8_t value) {
    const double s = value / 255.0;
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}
inline std::uint8_t srgb_from_linear(double value) {
    const double l = std::clamp(value, 0.0, 1.0);
    const double s = l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
    return std::uint8_t(s * 255 + 0.5);
}
inline Vec3d linear_from_srgb(Rgb8 c) {
    return {linear_from_srgb(c.r), linear_from_srgb(c.g), linear_from_srgb(c.b)};
}
inline Rgb8 srgb_from_linear(Vec3d c) {
    return {srgb_from_linear(c.x), srgb_from_linear(c.y), srgb_from_linear(c.z)};
}

}  // namespace pliant::render
