// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Replays a session's records on a scene.

#pragma once

#include <pliant/volume.h>

#include <span>

#include "session/scene.h"
#include "session/session_log.h"

namespace pliant::serve {

/// State to compare at marks; comparing the volume needs a pass over all voxels.
enum class Compare { Nothing, Tissue, All };

/// Repeats recorded sweeps. @returns their duration [ms]
Result<double> sweep_recorded(Scene& scene, const SessionSweeps& sweeps);
/// Loads a recorded state. @returns Unreadable if its file has changed; errors of the tissue
Status load_recorded(Scene& scene, const SessionState& state);

/// @param before  number of earlier records, for messages
/// @returns Unreadable if a command is refused that was carried out when recorded, or a mark
///          differs
Status replay_into(Scene& scene, std::span<const SessionRecord> records, Compare compare,
                   const Progress& progress = {}, std::size_t before = 0);

}  // namespace pliant::serve
