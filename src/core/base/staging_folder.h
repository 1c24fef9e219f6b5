// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The temporary folder of outputs, beside their targets:
//
//     scan.nrrd                    target of an output
//     .pliant-out-Xa81Qe/          locked (flock) while its process lives
//         0/scan.nrrd              becomes scan.nrrd
//         0/...                    accompanying files
//         before-0/scan.nrrd       hard link to the old file, during the commit
//         journal                  decides the commit (staging_journal.h)
//
// The lock ends with the process in every case. So a folder without a lock is a leftover,
// independent of process identifiers.

#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "base/descriptor.h"

namespace pliant::staging {

inline constexpr std::string_view kPrefix = ".pliant-out-";

/// Called before each step that changes a file or folder; tests end the process there.
inline void (*g_before_step)() = nullptr;
inline void before_step() {
    if (g_before_step) g_before_step();
}

enum class Lock {
    Taken,
    Busy,
    Impossible,  ///< on this file system
    Gone,        ///< there is no such folder, or it belongs to another user
    Unknown,     ///< the folder can't be opened
};

/// Opens an existing temporary folder of this user, without following a link.
/// @param waits  for another process that holds the lock
/// @returns nullopt for Gone and Unknown
std::optional<Descriptor> open_and_lock(const std::filesystem::path& folder, bool waits,
                                        Lock& lock);

/// Removes a folder recursively. Async-signal-safe.
void remove_tree(const char* folder) noexcept;

/// Syncs a folder or file to the disk; file systems without support are no error.
std::error_code sync_to_disk(const std::filesystem::path& path) noexcept;

/// A temporary folder of this process. The destructor and end_process remove it.
class Folder {
  public:
    /// @returns null, with the error, if parent isn't writable
    static std::unique_ptr<Folder> create(const std::filesystem::path& parent,
                                          std::error_code& error);
    ~Folder();
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    const std::filesystem::path& path() const { return m_path; }
    const std::filesystem::path& parent() const { return m_parent; }
    /// Adds a folder for one output and its accompanying files.
    std::filesystem::path add_slot(std::error_code& error);
    int slot_count() const { return m_slot_count; }
    /// Leaves the folder to the next run.
    void keep() noexcept;

  private:
    Folder(std::filesystem::path parent, std::filesystem::path path, Descriptor lock);

    std::filesystem::path m_parent, m_path;
    Descriptor m_lock;
    int m_slot = -1;
    int m_slot_count = 0;
    bool m_is_kept = false;
};

/// Whether a path lies in a temporary folder of this process.
bool is_staged(const std::filesystem::path& path);

/// Defers end_process during its lifetime: during commits, and during the creation of a folder that
/// isn't registered yet.
class Commit {
  public:
    Commit();
    ~Commit();
    Commit(const Commit&) = delete;
    Commit& operator=(const Commit&) = delete;
};

}  // namespace pliant::staging
