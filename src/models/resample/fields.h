// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacements slice by slice, and local measures, for a lattice without a tissue.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/volume.h>

#include "field/field.h"

namespace pliant {

/// jacobian_field and strain_field of a lattice.
Volume jacobian_of_field(const Field& field, const TaskArena& arena);
Volume strain_of_field(const Field& field, const TaskArena& arena);

}  // namespace pliant

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// Keeps a reference: the lattice must outlive it unchanged.
FieldSlices slices_of(const Field& field);

}  // namespace pliant
#pragma GCC visibility pop
