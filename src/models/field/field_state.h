// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Check of a field's state, element by element and cell by cell, independent of any solver.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/deformation.h>

#include <cstdint>
#include <functional>

#include "field/cell_block.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// Visits a block of cells that has moved; called from several threads.
using VisitBlock = std::function<void(Vec3i coord, const CellBlock& block)>;

DeformationState state_of_field(const Field& field, const TaskArena& arena,
                                const VisitBlock& visit = {});

/// Sum of a hash of every moved or edited element and its displacement or flags: independent of the
/// order.
std::uint64_t hash_state(const Field& field);

/// Smallest box around all moved elements.
Box3i moved_box(const Field& field);

}  // namespace pliant
#pragma GCC visibility pop
