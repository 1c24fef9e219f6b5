// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parts of the page, in order.

#pragma once

#include <pliant/core/tasks.h>

#include <filesystem>

#include "page.h"

namespace pliant::results {

/// Figures 1 to 3, and 5 to 8, of [Gibson1996].
void add_gibson(Page& page, const TaskArena& arena);
/// Figures 1 to 3: the chain and the mail that explain the rule.
void add_chains(Page& page, const TaskArena& arena);
/// Figures 5.1 to 5.8 and 5.10 of [Draeger2005]: the cubes.
void add_cubes(Page& page, const TaskArena& arena);
/// Figures 5.9, 5.11 and 5.12: the nose, opposite walls, the bump.
/// @param scans  folder with the head
void add_passages(Page& page, const std::filesystem::path& scans, const TaskArena& arena);
/// Figure 5.9: the nose.
void add_nose(Page& page, const std::filesystem::path& scans, const TaskArena& arena);
/// Figures 6.1 and 6.2, the tables of timings.
void add_timings(Page& page, const TaskArena& arena);
/// A drag at 60 Hz across two scans. @param scans  folder with the scans
void add_drags(Page& page, const std::filesystem::path& scans, const TaskArena& arena);

}  // namespace pliant::results
