// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What can be taken home. The scene's owner makes a copy of what is needed, at the cost of what was
// deformed; another thread makes a file of it. The files are, byte for byte, those that
// `pliant deform` would write of the same state.

#pragma once

#include <pliant/result.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>

#include "serve/scene.h"
#include "serve/session_log.h"

namespace pliant::serve {

enum class SaveKind { Volume, Displacement, Transform, Session };

/// By the file's name: "volume.nrrd", …
std::optional<SaveKind> save_kind_of(std::string_view name);
std::string_view name_of(SaveKind kind);

/// Writes a file of what was taken; from any thread, once.
using FileWriter = std::function<Status(const std::filesystem::path& path)>;

/// Takes what is there now. On the owner's thread, where nobody changes it meanwhile.
/// @pre kind is not Session
FileWriter save_later(SaveKind kind, const Scene& scene);
FileWriter save_session_later(SessionPart part, const Scene& scene);

}  // namespace pliant::serve
