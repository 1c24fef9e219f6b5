// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Loads as forces on nodes, so that they do the same work on every displacement that the elements
// can have.

#pragma once

#include <pliant/fem.h>

#include <span>

#include "fem/held_nodes.h"
#include "fem/node_vector.h"
#include "fem/solid_shape.h"

namespace pliant {

/// @returns in µN; InvalidArgument that names the load
Result<NodeVector> nodal_forces(const SolidShape& shape, std::span<const ElasticMaterial> materials,
                                std::span<const std::int32_t> material_of, const HeldNodes& held,
                                const ElasticLoads& loads);

}  // namespace pliant
