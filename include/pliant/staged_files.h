// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Outputs that appear together or not at all: each file is written under a temporary folder beside
// its place, and all are renamed when everything is written.

#pragma once

#include <pliant/result.h>

#include <filesystem>
#include <vector>

namespace pliant {

class StagedFiles {
  public:
    StagedFiles() = default;
    StagedFiles(const StagedFiles&) = delete;
    StagedFiles& operator=(const StagedFiles&) = delete;
    /// Removes what was staged and not committed.
    ~StagedFiles();

    /// Where to write the file that shall become target. The name stays the same, so formats that
    /// name a second file (.nhdr and its data) can be staged too.
    /// @returns Unwritable if target's folder is missing, is no folder, or can't be written
    Result<std::filesystem::path> stage(const std::filesystem::path& target);

    /// Renames everything to its place. Data files go before the headers that name them.
    Status commit();

  private:
    struct Entry {
        std::filesystem::path folder;  ///< temporary
        std::filesystem::path target;
    };
    std::vector<Entry> m_entries;
};

}  // namespace pliant
