// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The state of the lattice looked at link by link and cell by cell, apart from the solvers.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/tasks.h>

#include "chainmail/lattice.h"

namespace pliant {

LatticeState check_lattice(const Lattice& lattice, const MaterialLaw& law, const TaskArena& arena);

/// Sum of a hash of every moved or edited element and its displacement or flags: independent of the
/// order.
std::uint64_t hash_state(const Lattice& lattice);

/// The smallest box that holds every moved element.
Box3i moved_box(const Lattice& lattice);

}  // namespace pliant
