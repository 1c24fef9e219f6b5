// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The journal of a commit as a file: words terminated by a zero byte, which file names can't
// contain.

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "base/staging_journal.h"

namespace pliant::staging {

struct Journal {
    std::vector<std::string> parts{};  ///< temporary folders of the other folders with outputs
    std::string first{};               ///< in a part: the folder with the deciding journal
    std::vector<Move> moves{};
};

/// @returns nullopt unless the file is complete, and all its names lie in one folder; an error if
///          the file can't be read, so that nobody knows
Result<std::optional<Journal>> read_journal(const std::filesystem::path& file);

/// Writes to a temporary name, syncs and renames.
std::error_code write_journal(const std::filesystem::path& folder, const char* name,
                              const Journal& journal);

}  // namespace pliant::staging
