// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacements slice by slice, of a lattice that is nobody's tissue any more.

#pragma once

#include <pliant/volume.h>

#include "chainmail/lattice.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// Keeps a reference: the lattice must outlive it unchanged.
FieldSlices slices_of(const Lattice& lattice);

}  // namespace pliant
#pragma GCC visibility pop
