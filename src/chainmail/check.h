// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The state of the lattice looked at link by link and cell by cell, apart from the solvers.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/tasks.h>

#include <functional>

#include "chainmail/allowance.h"
#include "chainmail/lattice.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// Limits of an element, apart from the lattice's own table.
using LimitsAt = std::function<ElementLimits(Vec3i ijk)>;

/// @param allowance  of links that may be outside of their limits; null: none may
LatticeState check_lattice(const Lattice& lattice, const LimitsAt& limits_at,
                           const TaskArena& arena, const Allowance* allowance = nullptr);

/// Sum of a hash of every moved or edited element and its displacement or flags: independent of the
/// order.
std::uint64_t hash_state(const Lattice& lattice);

/// The smallest box that holds every moved element.
Box3i moved_box(const Lattice& lattice);

}  // namespace pliant
#pragma GCC visibility pop
