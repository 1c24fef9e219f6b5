// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Choice of the elements that a tool grabs, in the deformed lattice.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/core/vec.h>

#include <optional>
#include <vector>

#include "lattice/lattice.h"

namespace pliant {

/// The eight corners of the cell whose deformed hexahedron holds the point (the multi-move of
/// [Draeger2005, 3.5.3]). @param point  continuous voxel index
/// @returns nothing if no cell holds the point (only in a folded lattice)
std::optional<std::vector<Vec3i>> grab_cell(const Lattice& lattice, Vec3d point);

/// All tissue elements of the scan whose present position is within the radius of the centre.
std::vector<Vec3i> grab_sphere(const Lattice& lattice, Vec3d centre, double radius_mm,
                               const TissueValues& tissue);

}  // namespace pliant
