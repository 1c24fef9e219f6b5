// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The pictures of the page, and the check of the reference by refinement.

#pragma once

#include <pliant/core/tasks.h>

#include "page.h"
#include "study.h"

namespace pliant::results {

/// Displacement below a tool, by depth.
void add_profile(Page& page, const TaskArena& arena);
/// Mean error over the time of a solve.
void add_error_over_time(Page& page, const Study& study);
/// Finite elements on the block beside twice as many along each axis, for some loads.
void add_refinement(Page& page, const TaskArena& arena);

}  // namespace pliant::results
