// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Suggests a first push in a scan.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/data/scan_values.h>
#include <pliant/render.h>

#include <optional>

#include "options.h"

namespace pliant::app {

/// Radius of the suggested sphere [mm]: 4, less in a small specimen, more in coarse voxels.
double suggested_radius_mm(const Grid& grid);

/// Finds a wall in the first view of the lumen that gives way to a push of 6 mm into it, or less in
/// a small specimen.
/// @returns nullopt if there is no lumen, or bone holds every visible wall
std::optional<PushOption> suggest_push(const Volume& volume, const ValueDefaults& values,
                                       double iso, Polarity polarity, const TaskArena& arena);

}  // namespace pliant::app
