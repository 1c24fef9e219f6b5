// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Downloads. The scene's owner copies the necessary state, at a cost proportional to the deformed
// part. Another thread writes the file. The files are byte-identical to those of `pliant deform`
// for the same state.

#pragma once

#include <pliant/result.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>

#include "session/scene.h"
#include "session/session_log.h"

namespace pliant::serve {

enum class SaveKind {
    Volume,
    Displacement,
    Transform,
    Session,
    VolumeNifti,
    VolumeMeta,
    VolumeVti,
    State
};

/// Kind of a download by its file name: "volume.nrrd", …
std::optional<SaveKind> save_kind_of(std::string_view name);
std::string_view name_of(SaveKind kind);

/// Writes the file of a copied state. Thread-safe; call it once.
using FileWriter = std::function<Status(const std::filesystem::path& path)>;

/// Copies the present state. Call it on the owner's thread.
/// @pre kind is neither Session nor State
FileWriter save_later(SaveKind kind, const Scene& scene);
/// Writes the tissue's state to a temporary file at once, as checkpoints are; the writer moves it.
Result<FileWriter> save_state_later(const Scene& scene);
FileWriter save_session_later(SessionPart part, const Scene& scene);

}  // namespace pliant::serve
