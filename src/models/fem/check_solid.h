// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Checks of a solid: its mesh, its materials, their assignment to cells.

#pragma once

#include <pliant/models/fem.h>

namespace pliant {

/// @returns InvalidArgument that names the cell, node or material
Status check_solid(const ElasticSolid& solid);
Status check_solid(const ElasticLattice& solid);

Status check_settings(const ElasticSettings& settings);

}  // namespace pliant
