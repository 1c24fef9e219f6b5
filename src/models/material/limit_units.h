// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Limits of links in the fixed-point units of the displacements.

#pragma once

#include <cmath>

#include "field/fixed_point.h"

namespace pliant {

/// Largest half of a link's limit [units]. Two of them, 1024 mm, never bind: no two displacements
/// differ by more than 2·kMaxMovementMm.
inline constexpr Fixed kMaxHalfLimit = 1 << 29;
/// Lag of a cut link [units].
inline constexpr Fixed kUnlinked = 2 * kMaxHalfLimit;

/// Rounds towards tighter. @pre mm ≥ 0
inline Fixed limit_units_from_mm(double mm) {
    const double units = std::floor(mm * kUnitsPerMm);
    return units < kMaxHalfLimit ? Fixed(units) : kMaxHalfLimit;
}

}  // namespace pliant
