// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacements and limits as 32-bit integers of 2⁻²⁰ mm, about a nanometre. Sums are exact and
// associative, so every solver gives the same bits in any order. The range is ±2048 mm.

#pragma once

#include <cmath>
#include <cstdint>

namespace pliant {

using Fixed = std::int32_t;

inline constexpr double kUnitsPerMm = 1 << 20;
/// Longest push and largest movement limit [mm]: a displacement plus a push still fits.
inline constexpr double kMaxMovementMm = 500;
/// Largest half of a link's limit [units]. Two of them, 1024 mm, never bind: no two displacements
/// differ by more than 2·kMaxMovementMm.
inline constexpr Fixed kMaxHalfLimit = 1 << 29;
/// Lag of a link that is cut [units].
inline constexpr Fixed kUnlinked = 2 * kMaxHalfLimit;

inline double mm_from_units(Fixed units) {
    return units / kUnitsPerMm;
}
inline Fixed units_from_mm(double mm) {
    return Fixed(std::lround(mm * kUnitsPerMm));
}
/// Rounds towards tighter. @pre mm ≥ 0
inline Fixed limit_units_from_mm(double mm) {
    const double units = std::floor(mm * kUnitsPerMm);
    return units < kMaxHalfLimit ? Fixed(units) : kMaxHalfLimit;
}

}  // namespace pliant
