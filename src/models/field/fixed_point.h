// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacements as 32-bit integers of 2⁻²⁰ mm, about a nanometre. Sums are exact and associative,
// so every solver gives the same bits in any order. The range is ±2048 mm.

#pragma once

#include <cmath>
#include <cstdint>

namespace pliant {

using Fixed = std::int32_t;

inline constexpr double kUnitsPerMm = 1 << 20;
/// Longest push and largest movement limit [mm]: a displacement plus a push still fits.
inline constexpr double kMaxMovementMm = 500;

inline double mm_from_units(Fixed units) {
    return units / kUnitsPerMm;
}
inline Fixed units_from_mm(double mm) {
    return Fixed(std::lround(mm * kUnitsPerMm));
}

}  // namespace pliant
