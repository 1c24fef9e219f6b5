// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacements slice by slice, for a lattice without a tissue.

#pragma once

#include <pliant/volume.h>

#include "field/field.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// Keeps a reference: the lattice must outlive it unchanged.
FieldSlices slices_of(const Field& field);

}  // namespace pliant
#pragma GCC visibility pop
