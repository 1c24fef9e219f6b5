// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Consistent nodal forces: they do the same work as the loads on every displacement in the element
// space.

#pragma once

#include <pliant/models/fem.h>

#include <span>

#include "fem/held_nodes.h"
#include "fem/node_vector.h"
#include "fem/solid_shape.h"

namespace pliant {

/// @returns forces in µN; InvalidArgument that names the load
Result<NodeVector> nodal_forces(const SolidShape& shape, std::span<const ElasticMaterial> materials,
                                std::span<const std::int32_t> material_of, const HeldNodes& held,
                                const ElasticLoads& loads);

}  // namespace pliant
