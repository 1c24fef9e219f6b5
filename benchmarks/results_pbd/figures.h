// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The parts of the page, in its order.

#pragma once

#include <pliant/tasks.h>

#include "page.h"
#include "value_of.h"

namespace pliant::results {

/// A vessel under pressure, with and without volume conservation.
void add_pressure(Page& page, const TaskArena& arena);
/// A vessel whose wall is pushed, with and without locality.
void add_push(Page& page, const TaskArena& arena);
/// Cases 1 to 15: expected, measured, tolerance.
void add_published(Page& page);
/// The cantilever of case 5, on several grids.
void add_cantilever(Page& page, const TaskArena& arena);

}  // namespace pliant::results
