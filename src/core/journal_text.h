// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The journal of a commit as a file: words that end in a zero byte, which no name has.

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "core/staging_journal.h"

namespace pliant::staging {

struct Journal {
    std::vector<std::string> parts{};  ///< temporary folders of the other places
    std::string first{};               ///< of a part: the folder with the journal that decides
    std::vector<Move> moves{};
};

/// @returns nothing unless the file is whole, and all its names lie in one folder
std::optional<Journal> read_journal(const std::filesystem::path& file);

/// Written under another name, synced, renamed.
std::error_code write_journal(const std::filesystem::path& folder, const char* name,
                              const Journal& journal);

}  // namespace pliant::staging
