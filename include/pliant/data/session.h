// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Recorded sessions: the commands of all clients and the sweeps between them. The scene has no
// clock, so a session replays to the same bits on any machine and with any number of threads.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/data/scan_values.h>
#include <pliant/own_tissue.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <functional>

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

struct ReplaySettings {
    /// Starts at the last but one checkpoint if it is valid, as Server::start does. Otherwise
    /// everything is replayed, and the state compared at each mark.
    bool from_checkpoint = false;
    MakeTissue own_tissue{};  ///< the server's, for a session that used it
    Progress progress{};
    /// Called with the tissue after the last record, and with the scan's values, whose threshold
    /// and polarity are the session's last ones. Its error becomes the replay's.
    std::function<Status(const Tissue& tissue, const ValueDefaults& values)> finish{};
};

/// Replays a recorded session without a server.
/// @returns NotFound; Unreadable if the file is damaged or a result differs from the recording
Result<ReplayReport> replay_session(const std::filesystem::path& path, const TaskArena& arena,
                                    const ReplaySettings& settings = {});

}  // namespace pliant
#pragma GCC visibility pop
