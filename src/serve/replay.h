// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Does a session's records to a scene again.

#pragma once

#include <pliant/volume.h>

#include <span>

#include "serve/scene.h"
#include "serve/session_log.h"

namespace pliant::serve {

/// A scene as it was when it began.
/// @returns InvalidArgument where the scan is another than recorded
Result<std::unique_ptr<Scene>> open_recorded(const SessionHeader& header, const TaskArena& arena);

/// @param compare_marks  whether marks are compared, which costs a look at the whole volume each
/// @param before  how many records there were before them, for messages
/// @returns Unreadable where a command is refused that was carried out then, or a mark differs
Status replay_into(Scene& scene, std::span<const SessionRecord> records, bool compare_marks,
                   const Progress& progress = {}, std::size_t before = 0);

}  // namespace pliant::serve
