// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each touched cell writes the voxels inside it.

#pragma once

#include <pliant/resample.h>

namespace pliant {

/// Finds the changeable voxels of a scan and writes them: see deform_volume.
Deformed deform_by_lattice(const Volume& original, const Lattice& lattice, Mapping mapping,
                           bool with_inverse, const TaskArena& arena);

}  // namespace pliant
