// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Half floats (IEEE 754 binary16): the format of the page's textures.

#pragma once

#include <bit>
#include <cstdint>

namespace pliant {

/// Rounds to nearest, ties to even. Values beyond ±65504 are clamped; NaN stays NaN.
inline std::uint16_t half_from_float(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const auto sign = std::uint16_t((bits >> 16) & 0x8000U);
    std::uint32_t size = bits & 0x7fffffffU;
    if (size > 0x7f800000U) return std::uint16_t(sign | 0x7e00U);
    if (size > 0x477fe000U) return std::uint16_t(sign | 0x7bffU);  // 65504
    if (size < 0x38800000U) {
        // Below 2⁻¹⁴ halves are multiples of 2⁻²⁴, like floats from 0.5 on, so an addition rounds.
        const float sum = std::bit_cast<float>(size) + 0.5F;
        return std::uint16_t(sign | (std::bit_cast<std::uint32_t>(sum) - 0x3f000000U));
    }
    size += 0xfffU + ((size >> 13) & 1U);
    return std::uint16_t(sign | ((size - 0x38000000U) >> 13));
}

inline float float_from_half(std::uint16_t half) {
    const std::uint32_t sign = std::uint32_t(half & 0x8000U) << 16;
    const std::uint32_t rest = half & 0x7fffU;
    if (rest >= 0x7c00U) return std::bit_cast<float>(sign | 0x7f800000U | ((rest & 0x3ffU) << 13));
    if (rest >= 0x400U) return std::bit_cast<float>(sign | ((rest << 13) + 0x38000000U));
    const float size = float(rest) * 0x1p-24F;
    return sign ? -size : size;
}

}  // namespace pliant
