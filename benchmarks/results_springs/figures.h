// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parts of the page, in order.

#pragma once

#include <pliant/tasks.h>

#include <filesystem>

#include "page.h"
#include "value_of.h"

namespace pliant::results {

/// Figures 9 and 10: the necessary depth of forces.
void add_depth(Page& page, const TaskArena& arena);
/// Figures 11 and 12: creep, hysteresis, the load curve; anisotropy.
void add_responses(Page& page, const TaskArena& arena);
/// Figure 13: scans deformed by springs. @param scans  folder
void add_scans(Page& page, const std::filesystem::path& scans, const TaskArena& arena);
/// Tables 1 and 2: identification.
void add_identification(Page& page, const TaskArena& arena);
/// Table 3: time for each layer.
void add_timings(Page& page, const TaskArena& arena);

}  // namespace pliant::results
