// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Light is summed in linear red, green and blue, 0…1; pictures are stored in sRGB.

#pragma once

#include <pliant/render.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace pliant::render {

inline double linear_from_srgb(std::uint8_t value) {
    const double s = value / 255.0;
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}
/// sRGB of light by its formula.
inline std::uint8_t srgb_by_formula(double value) {
    const double l = std::clamp(value, 0.0, 1.0);
    const double s = l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
    return std::uint8_t(s * 255 + 0.5);
}

/// The same, by comparisons with the light at which each value begins.
class SrgbTable {
  public:
    SrgbTable() {
        m_begin[0] = 0;
        for (int code = 1; code < 256; ++code) m_begin[std::size_t(code)] = begin_of(code);
        for (std::size_t n = 0; n < m_guess.size(); ++n)
            m_guess[n] = srgb_by_formula(double(n) / kParts);
    }
    std::uint8_t operator()(double value) const {
        const double l = value > 0 ? std::min(value, 1.0) : 0;  // NaN is black
        std::size_t code = m_guess[std::size_t(l * kParts)];
        while (code < 255 && l >= m_begin[code + 1]) ++code;
        return std::uint8_t(code);
    }

  private:
    static constexpr int kParts = 4096;

    /// Smallest number with this value or a larger one.
    static double begin_of(int code) {
        double low = 0, high = 1;  // the value is smaller at low
        for (;;) {
            const double middle = low + 0.5 * (high - low);
            if (!(low < middle && middle < high)) return high;
            (srgb_by_formula(middle) < code ? low : high) = middle;
        }
    }

    std::array<double, 256> m_begin;
    std::array<std::uint8_t, kParts + 1> m_guess;
};

inline std::uint8_t srgb_from_linear(double value) {
    static const SrgbTable table;
    return table(value);
}
inline Vec3d linear_from_srgb(Rgb8 c) {
    return {linear_from_srgb(c.r), linear_from_srgb(c.g), linear_from_srgb(c.b)};
}
inline Rgb8 srgb_from_linear(Vec3d c) {
    return {srgb_from_linear(c.x), srgb_from_linear(c.y), srgb_from_linear(c.z)};
}

}  // namespace pliant::render
