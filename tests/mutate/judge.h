// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Allowed behaviour of the program for a damaged file: it accepts it silently, or refuses it in one
// line and leaves no files behind. Everything else is a fault.

#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "mutate/child.h"

namespace pliant::mutate {

inline constexpr int kTaken = 0, kRefused = 2;  ///< exit statuses of docs/reference/conventions.md
inline constexpr double kMaxPeakMb = 1024;
inline constexpr std::size_t kMaxLineBytes = 408;  ///< "pliant: " and 400 bytes
inline constexpr std::size_t kMaxAnswerBytes = 400;

/// Bytes of every file in a folder by relative path; folders end with '/' and have no bytes. A link
/// is its target's name.
using Contents = std::map<std::string, std::string>;
Contents contents_of(const std::filesystem::path& folder);

struct Rules {
    bool judge_memory = true;  ///< peak of resident memory; not with sanitizers
    bool may_be_long =
        false;  ///< the file says how much work there is: a limit of time is no fault
    bool expects_json = false;  ///< on standard output, where the file is taken
};

/// @param before, after  the folder's contents; `.tmp/` is the program's TMPDIR
/// @returns a short text for each fault; none for a run as it should be
std::vector<std::string> faults_of(const Ended& run, const Contents& before, const Contents& after,
                                   const Rules& rules);

/// A server's answer to a request.
struct Answer {
    std::string status;  ///< "200"; empty: the connection ended without one
    std::string body;
    double seconds = 0;  ///< until it was there
};

/// An answer is one line of at most 400 bytes; of a list of series (300) one of any length.
/// @param expected  statuses that are no fault
std::vector<std::string> faults_of(const Answer& answer, const std::vector<std::string>& expected,
                                   double max_seconds);

/// Text with other than printable bytes as \xNN, cut to max_length characters.
std::string printable(std::string_view text, std::size_t max_length = 160);

}  // namespace pliant::mutate
