// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Atomic commit of several files: if the process is killed, either all old files or all new files
// are there after the next run in the folder.
//
//     prepare    the new files are on the disk, in the temporary folder; old ones get a hard link
//     journal    written to a temporary name, synced, renamed: now the commit is decided
//     rename     each file to its target; with a journal the next run can continue here
//     remove     the journal, then the temporary folder
//
// If a rename fails, the journal is renamed to `undo`, and the old files are restored. Both
// directions can be repeated from any step. A journal contains only names in its own folder, so
// that a foreign folder can't rename files outside of its location. If outputs lie in several
// folders, the first one's journal decides, and names the temporary folders of the others.

#pragma once

#include <pliant/result.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/staging_folder.h"

namespace pliant::staging {

/// Move of a file or new folder to its target.
struct Move {
    std::string slot;       ///< number of the folder in the temporary one
    std::string name;       ///< name in that folder, and beside the temporary folder
    bool replaces = false;  ///< there was an old file
};

/// The moves of one temporary folder.
struct Moves {
    Folder* folder = nullptr;
    std::vector<Move> moves;  ///< in this order
};

/// Carries out all moves, or none.
/// @pre the new files are synced; not empty
Status commit(std::vector<Moves>& all);

/// Finishes or rolls back commits of ended processes, and removes their folders.
void sweep(const std::filesystem::path& parent);

}  // namespace pliant::staging
