// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// √(x² + y²) with the same bits on every machine: C libraries use fused operations in hypot where
// the processor has them. The others of their functions that the library calls choose at run time,
// or are the same (docs/developers/robustness.md, Other machines).

#pragma once

#include <algorithm>
#include <cmath>

namespace pliant {

/// Corrects the rounding errors of √(x² + y²), without fused operations [Borges2020].
/// @pre x ≥ y > 0, and no square leaves the range of normal numbers
inline double corrected_hypot(double x, double y) {
    const double h = std::sqrt(x * x + y * y);
    if (h <= 2 * y) {
        const double d = h - y;
        return h - (x * (2 * d - x) + (d - 2 * (x - y)) * d) / (2 * h);
    }
    const double d = h - x;
    return h - (2 * d * (x - 2 * y) + ((4 * d - y) * y + d * d)) / (2 * h);
}

/// √(x² + y²), without overflow; that of the GNU C library (2.35 to 2.41) on x86-64.
inline double hypot(double x, double y) {
    constexpr double kScale = 0x1p600, kLarge = 0x1p511, kSmall = 0x1p-459, kHidden = 0x1p-54;
    x = std::abs(x);
    y = std::abs(y);
    if (std::isinf(x) || std::isinf(y)) return HUGE_VAL;
    if (x < y) std::swap(x, y);
    if (!(y > x * kHidden)) return x + y;
    if (x > kLarge) return corrected_hypot(x / kScale, y / kScale) * kScale;
    if (y < kSmall) return corrected_hypot(x * kScale, y * kScale) / kScale;
    return corrected_hypot(x, y);
}

}  // namespace pliant
