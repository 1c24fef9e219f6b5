// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A first place to push in a scan that nobody has looked at yet.

#pragma once

#include <pliant/tasks.h>
#include <pliant/volume.h>

#include <optional>

#include "options.h"

namespace pliant::app {

/// Radius of the sphere that the suggestion is made for [mm].
inline constexpr double kSuggestedRadiusMm = 4;

/// A wall that the first view into the lumen shows, and that gives way to a push of 6 mm into it.
/// @returns nothing if there is no lumen, or every wall in view is held by bone
std::optional<PushOption> suggest_push(const Volume& volume, const TaskArena& arena);

}  // namespace pliant::app
