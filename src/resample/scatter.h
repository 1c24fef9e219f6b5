// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each touched cell writes the voxels inside it.

#pragma once

#include <pliant/resample.h>

#include "resample/touched.h"

namespace pliant {

/// Finds the changeable voxels of a scan and writes them: see deform_volume.
Deformed deform_by_lattice(const Volume& original, const Lattice& lattice, Mapping mapping,
                           bool with_inverse, const TaskArena& arena);

/// Fills the changeable voxels of `deformed.volume`, which starts as a copy of the original, and
/// deformed.inverse_mm where that isn't empty.
/// @returns the number of voxels that no cell covers; they become air
std::int64_t scatter_cells(const Volume& original, const Lattice& lattice, Mapping mapping,
                           const VoxelMask& changeable, const TaskArena& arena, Deformed& deformed);

}  // namespace pliant
