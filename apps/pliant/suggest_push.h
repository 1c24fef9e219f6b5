// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Suggests a first push in a scan.

#pragma once

#include <pliant/tasks.h>
#include <pliant/volume.h>

#include <optional>

#include "options.h"

namespace pliant::app {

/// Radius of the suggested sphere [mm].
inline constexpr double kSuggestedRadiusMm = 4;

/// Finds a wall in the first view of the lumen that gives way to a push of 6 mm into it.
/// @returns nullopt if there is no lumen, or bone holds every visible wall
std::optional<PushOption> suggest_push(const Volume& volume, const TaskArena& arena);

}  // namespace pliant::app
