// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A program run as a child process: limits on time, memory and files, and all that is known of how
// it ended.

#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace pliant::mutate {

struct Limits {
    unsigned cpu_s = 10;   ///< 0: no limit
    unsigned wall_s = 60;  ///< for a machine with other work; 0: no limit
    std::uint64_t memory = std::uint64_t(2500) << 20;    ///< address space [bytes]; 0: no limit
    std::uint64_t file_bytes = std::uint64_t(64) << 20;  ///< limit of each written file
};

struct Ended {
    int status = -1;        ///< exit status; −1 where a signal ended it
    int signal = 0;         ///< that ended it; 0: none
    bool too_long = false;  ///< a limit of time ended it
    double seconds = 0;     ///< wall-clock time
    double peak_mb = 0;     ///< largest resident memory
    std::string out, err;   ///< standard output and error
};

/// `program arguments…` in a folder, as a process group of its own. TMPDIR is the folder's `.tmp`.
class Child {
  public:
    Child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
          const std::filesystem::path& folder, const Limits& limits);
    /// Kills it, and the processes that it leaves behind.
    ~Child();
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    pid_t process() const { return m_process; }
    /// Whether it has ended; waits for nothing.
    bool has_ended();
    /// Waits for its end, and kills the processes that it leaves behind.
    /// @returns status 127 where the program can't be run
    Ended wait();
    /// Standard output and error so far.
    std::string out() const;
    std::string err() const;

  private:
    Limits m_limits;
    pid_t m_process = -1;
    int m_outputs[2];
    std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

/// Runs it, and waits for its end.
Ended run_child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                const std::filesystem::path& folder, const Limits& limits);

}  // namespace pliant::mutate
