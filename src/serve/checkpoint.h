// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Checkpoints of a session: the tissue's state in a file beside it, so that opening a session of
// hours does not do hours of work again. The session alone stays the truth. A checkpoint is used
// where its file is whole and is the one that the session names; otherwise an earlier one, or none.
//
// There are two files, written in turn. Opening takes the last checkpoint but one: what was done
// since then can be undone, as it could before.

#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "serve/scene.h"
#include "serve/session_log.h"

namespace pliant::serve {

std::filesystem::path checkpoint_path(const std::filesystem::path& session, int number);

/// Lets the scene rest, and saves it. What is returned belongs into the session in any case: it
/// says that the scene rested. Its file is 0 where it could not be saved.
/// @pre scene.is_quiet(), and its deformed volume is up to date
/// @returns LimitExceeded where memory runs out: the scene then rests only in that no step goes on
Result<SessionCheckpoint> save_checkpoint(Scene& scene, const std::filesystem::path& session,
                                          int number, Status& saved);

struct Reopened {
    std::unique_ptr<Scene> scene;
    int number = 0;                    ///< of the checkpoint; 0: from the start
    std::int64_t forgot = 0;           ///< with a checkpoint: SessionForget::steps
    std::vector<std::string> notes{};  ///< about checkpoints that were of no use
};
/// The scene at the end of a session: that of the scan that was opened last.
Result<Reopened> reopen(const SessionFile& file, const std::filesystem::path& session,
                        const TaskArena& arena);

/// The session's scan. @returns InvalidArgument where it is another one now
Result<std::unique_ptr<Scene>> open_recorded(const SessionHeader& header, const TaskArena& arena);

}  // namespace pliant::serve
