// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The commit of several files, so that a process that is killed in it leaves all the old ones or
// all the new ones once the next run has been in the folder.
//
//     prepare    the new files are on the disk, in the temporary folder; old ones get a second name
//     journal    written under another name, synced, renamed: now the commit is decided
//     rename     each file to its place; with a journal the next run can go on here
//     remove     the journal, then the temporary folder
//
// Where a rename fails, the journal is renamed to `undo`, and the old files are put back. Both ways
// can be repeated from any step. A journal holds names in its own folder only, so that a folder
// from elsewhere can't rename anything outside of where it lies. Where outputs lie in several
// folders, the first one's journal decides, and names the temporary folders of the others.

#pragma once

#include <pliant/result.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/staging_folder.h"

namespace pliant::staging {

/// A file, or a new folder, to be put in its place.
struct Move {
    std::string place;      ///< folder in the temporary one: a number
    std::string name;       ///< in that folder, and beside the temporary one
    bool replaces = false;  ///< there was an old file
};

/// The moves of one temporary folder.
struct Moves {
    const Folder* folder = nullptr;
    std::vector<Move> moves;  ///< in this order
};

/// Carries out all moves, or none.
/// @pre the new files are synced; not empty
Status commit(std::vector<Moves>& all);

/// Finishes or takes back commits of processes that have ended, and removes their folders.
void sweep(const std::filesystem::path& parent);

}  // namespace pliant::staging
