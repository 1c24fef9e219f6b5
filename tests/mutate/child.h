// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A program run as a child process: limits on time, memory and files, and all that is known of how
// it ended.

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace pliant::mutate {

struct Limits {
    unsigned cpu_s = 10;
    unsigned wall_s = 60;                                ///< for a machine with other work
    std::uint64_t memory = std::uint64_t(2500) << 20;    ///< address space [bytes]; 0: no limit
    std::uint64_t file_bytes = std::uint64_t(64) << 20;  ///< of each file that is written
};

struct Ended {
    int status = -1;        ///< exit status; −1 where a signal ended it
    int signal = 0;         ///< that ended it; 0: none
    bool too_long = false;  ///< a limit of time ended it
    double seconds = 0;     ///< wall-clock time
    double peak_mb = 0;     ///< largest resident memory
    std::string out, err;   ///< standard output and error
};

/// Runs `program arguments…` in a folder, as a process group of its own, and waits. TMPDIR is the
/// folder's `.tmp`. Processes that it leaves behind are killed.
/// @returns status 127 where the program can't be run
Ended run_child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                const std::filesystem::path& folder, const Limits& limits);

}  // namespace pliant::mutate
