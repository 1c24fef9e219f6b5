// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The control lattice and the network of a scan and its settings.

#pragma once

#include <pliant/tissues.h>

#include <string>

namespace pliant {

/// Cells of whole voxels, as many as fit into the region, centred in it.
Result<ControlGrid> control_grid(const Volume& volume, const SpringDeformationSettings& settings);
Result<SpringTissue> tissue_of(const Volume& volume, const ControlGrid& grid,
                               const SpringDeformationSettings& settings);

}  // namespace pliant
