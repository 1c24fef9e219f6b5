// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parts of the page.

#pragma once

#include <pliant/core/tasks.h>

#include "chart.h"
#include "page.h"

namespace pliant::results {

void add_stability(Page& page);
void add_taps(Page& page);
void add_energies(Page& page, const TaskArena& arena);
void add_depth(Page& page, const TaskArena& arena);

}  // namespace pliant::results
