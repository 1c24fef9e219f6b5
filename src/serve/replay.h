// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Does a session's records to a scene again.

#pragma once

#include <pliant/volume.h>

#include <span>

#include "serve/scene.h"
#include "serve/session_log.h"

namespace pliant::serve {

/// What of marks is compared; the volume costs a look at all of it each time.
enum class Compare { Nothing, Tissue, All };

/// @param before  how many records there were before them, for messages
/// @returns Unreadable where a command is refused that was carried out then, or a mark differs
Status replay_into(Scene& scene, std::span<const SessionRecord> records, Compare compare,
                   const Progress& progress = {}, std::size_t before = 0);

}  // namespace pliant::serve
