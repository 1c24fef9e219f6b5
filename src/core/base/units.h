// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Inside a scene lengths are in mm, masses in g and times in s, so that forces are in g·mm/s² = µN.
// A user's forces are in N. A product with one factor and a quotient by the other differ in the
// last bit: keep the one that a formula has.

#pragma once

namespace pliant {

inline constexpr double kNewtonsPerMicronewton = 1e-6;
inline constexpr double kMicronewtonsPerNewton = 1e6;
inline constexpr double kNanojoulesPerMillijoule = 1e6;
inline constexpr double kGramsPerMm3 = 1e-6;  ///< in 1 kg/m³

}  // namespace pliant
