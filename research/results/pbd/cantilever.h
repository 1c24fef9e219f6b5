// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The cantilever of case 5: 20 × 20 × 200 mm under its own weight, held at one end.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/models/fem.h>

namespace pliant::results {

inline constexpr struct {
    double young, nu, density, gravity;
    double exact_mm;  ///< beam theory, with shear
} kCantilever{1e7, 0.3, 1100, 9.81, 6.541};

/// `across`² × `along` boxes of five tetrahedra each [m].
TetMesh cantilever_of(int along, int across);
/// Deflection of its tip, by position-based solids or by finite elements of 5 × 5 × 30 nodes [mm].
double sag_of_solids(int along, int across, const TaskArena& arena);
double sag_of_hexahedra(HexElement element, const TaskArena& arena);

}  // namespace pliant::results
