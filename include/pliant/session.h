// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Recorded sessions: the commands of all clients and the sweeps between them. The scene has no
// clock, so a session replays to the same bits on any machine and with any number of threads.

#pragma once

#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/tissue.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>

#pragma GCC visibility push(default)
namespace pliant {

struct ReplayReport {
    std::int64_t commands = 0;
    std::int64_t marks = 0;  ///< recorded states that were compared; all agreed
    std::uint64_t cut_off_bytes = 0;
    int from_checkpoint = 0;        ///< 0: from the start
    std::uint64_t volume_hash = 0;  ///< hash_volume of the deformed volume
    std::uint64_t tissue_hash = 0;  ///< ChainMail::hash
};

/// Replays a recorded session without a server.
/// @param from_checkpoint  starts at the last but one checkpoint if it is valid, as Server::start
///                         does; otherwise replays everything and compares the state at each mark
/// @param own_tissue  the server's, for a session that used it
/// @returns NotFound; Unreadable if the file is damaged or a result differs from the recording
Result<ReplayReport> replay_session(const std::filesystem::path& path, const TaskArena& arena,
                                    const Progress& progress = {}, bool from_checkpoint = false,
                                    const MakeTissue& own_tissue = {});

}  // namespace pliant
#pragma GCC visibility pop
