// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Check of the lattice's state, link by link and cell by cell, independent of the solvers.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/core/tasks.h>

#include <functional>

#include "lattice/allowance.h"
#include "lattice/lattice.h"

namespace pliant {

/// Limits of an element, independent of the lattice's own table.
using LimitsAt = std::function<ElementLimits(Vec3i ijk)>;

/// @param allowance  excuses of links outside of their limits; null: no link may be outside
LatticeState check_lattice(const Lattice& lattice, const LimitsAt& limits_at,
                           const TaskArena& arena, const Allowance* allowance = nullptr);

}  // namespace pliant
