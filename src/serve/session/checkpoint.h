// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Checkpoints of a session: the tissue's state in a file beside it. They shorten the replay of a
// long session when it is opened. The session stays authoritative: a checkpoint is used only if its
// file is intact and matches the session's record; otherwise an earlier one, or none.
//
// There are two files, written alternately. Opening uses the last checkpoint but one, so that steps
// after it can still be undone.

#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "session/scene.h"
#include "session/session_log.h"

namespace pliant::serve {

/// Checksum at the end of a state's file, which loading verifies. @returns Unreadable
Result<std::uint64_t> checksum_of(const std::filesystem::path& state);

std::filesystem::path checkpoint_path(const std::filesystem::path& session, int number);

/// Brings the scene to rest and saves it. Record the result in the session in any case, because the
/// scene has come to rest. Its file is 0 if it couldn't be saved.
/// @pre scene.is_quiet(), and its deformed volume is up to date
/// @returns LimitExceeded if memory runs out; then the only change is that the open step has ended
Result<SessionCheckpoint> save_checkpoint(Scene& scene, const std::filesystem::path& session,
                                          int number, Status& saved);

struct Reopened {
    std::unique_ptr<Scene> scene;
    int number = 0;                    ///< number of the checkpoint; 0: full replay
    std::int64_t forgot = 0;           ///< with a checkpoint: SessionForget::steps
    std::vector<std::string> notes{};  ///< remarks on unusable checkpoints
};
/// Returns the scene at the end of a session: that of its last scan.
Result<Reopened> reopen(const SessionFile& file, const std::filesystem::path& session,
                        const TaskArena& arena);

/// Opens the session's scan. @returns InvalidArgument if the scan has changed
Result<std::unique_ptr<Scene>> open_recorded(const SessionHeader& header, const TaskArena& arena);

}  // namespace pliant::serve
