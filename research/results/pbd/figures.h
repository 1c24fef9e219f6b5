// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parts of the page, in order.

#pragma once

#include <pliant/core/tasks.h>

#include <string>

#include "page.h"
#include "value_of.h"

namespace pliant::results {

/// A catheter that deforms a vessel. @param scenes  folder of the scene files
void add_catheters(Page& page, const std::string& scenes, const TaskArena& arena);
/// A catheter's tip in a vessel of the paper's constraints, with and without volumes.
void add_wall_models(Page& page, const std::string& scenes, const TaskArena& arena);
void add_volumes(Page& page, const TaskArena& arena);
/// The scenes of real vessels. @param scenes  folder of the scene files
void add_walls(Page& page, const std::string& scenes, const TaskArena& arena);
/// A vessel under pressure, with and without volume conservation.
void add_pressure(Page& page, const TaskArena& arena);
/// A vessel whose wall is pushed, with and without local simulation.
void add_push(Page& page, const TaskArena& arena);
/// Cases 1 to 15: expected, measured, tolerance.
void add_published(Page& page);
/// The cantilever of case 5, on several grids.
void add_cantilever(Page& page, const TaskArena& arena);

}  // namespace pliant::results
