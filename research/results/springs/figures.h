// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parts of the page, in order.

#pragma once

#include <pliant/core/tasks.h>

#include <filesystem>

#include "page.h"
#include "value_of.h"

namespace pliant::results {

/// Figures 9 and 10: the necessary depth of forces.
void add_depth(Page& page, const TaskArena& arena);
/// [Choi2004, 3.1.4]: the order of updates.
void add_orders(Page& page);
/// Figures 11 and 12: creep, hysteresis, the load curve; anisotropy.
void add_responses(Page& page, const TaskArena& arena);
/// [Choi2004, 2.1 and 2.2]: stress relaxation of the models of Figure 1.
void add_relaxation(Page& page, const TaskArena& arena);
/// A load curve that bends as that of tissue.
void add_crimp(Page& page, const TaskArena& arena);
/// Springs identified against a transversely isotropic block [Choi2004, Eq. 3].
void add_fibres(Page& page, const TaskArena& arena);
/// Figure 13: scans deformed by springs. @param scans  folder
void add_scans(Page& page, const std::filesystem::path& scans, const TaskArena& arena);
/// Figure 8: a point against a net of triangles.
void add_touch_point(Page& page, const TaskArena& arena);
/// Figure 15: surfaces of organs, touched by a probe. @param scans  folder
void add_touched(Page& page, const std::filesystem::path& scans, const TaskArena& arena);
/// Tables 1 and 2: identification.
void add_identification(Page& page, const TaskArena& arena);
/// Table 3: time for each layer.
void add_timings(Page& page, const TaskArena& arena);

}  // namespace pliant::results
