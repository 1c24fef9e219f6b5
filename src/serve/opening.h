// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// From files that came in to a scene: which of them is the scan, and whether it may be read.

#pragma once

#include <pliant/tasks.h>

#include "serve/hub.h"
#include "serve/upload.h"

namespace pliant::serve {

/// Reads the scan, makes its scene, and keeps the files if a session needs them. On a thread that
/// has time; the arena is the scene's later on, and isn't used here.
/// @returns one line that names the file as the client does
Result<NewScene> open_upload(Upload& upload, const TaskArena& arena);

}  // namespace pliant::serve
