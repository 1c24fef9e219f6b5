// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The temporary folder that outputs are written to, beside their places:
//
//     scan.nrrd                    the place of an output
//     .pliant-out-Xa81Qe/          locked (flock) while its process lives
//         0/scan.nrrd              becomes scan.nrrd
//         0/...                    files that go with it
//         before-0/scan.nrrd       a second name of the old file, during the commit
//         journal                  from here on the commit is decided (staging_journal.h)
//
// The lock ends with the process, however that ends. So a folder without a lock is a leftover,
// whatever the process identifiers are.

#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace pliant::staging {

inline constexpr std::string_view kPrefix = ".pliant-out-";

/// Called before each step that changes a file or folder; a test ends the process there.
inline void (*g_before_step)() = nullptr;
inline void before_step() {
    if (g_before_step) g_before_step();
}

/// An open file descriptor.
class Descriptor {
  public:
    explicit Descriptor(int number = -1) : m_number(number) {}
    ~Descriptor();
    Descriptor(Descriptor&& other) noexcept : m_number(other.release()) {}
    Descriptor& operator=(Descriptor&& other) noexcept;

    int number() const { return m_number; }
    bool is_open() const { return m_number >= 0; }
    int release() {
        const int number = m_number;
        m_number = -1;
        return number;
    }

  private:
    int m_number;
};

enum class Lock { Taken, Busy, Impossible };

/// A temporary folder that exists already, of this user, and no link.
/// @param waits  for another process that holds it
/// @returns nothing where there is none, or it is another user's
std::optional<Descriptor> open_and_lock(const std::filesystem::path& folder, bool waits,
                                        Lock& lock);

/// Removes all that a folder holds, and then the folder. Async-signal-safe.
void remove_tree(const char* folder) noexcept;

/// Writes a folder's or file's bytes and names to the disk; where a file system can't, that is no
/// error.
std::error_code sync_to_disk(const std::filesystem::path& path) noexcept;

/// A temporary folder of this process. It is removed with the object, and by end_process.
class Folder {
  public:
    /// @returns nothing, with the reason, where parent can't be written
    static std::unique_ptr<Folder> create(const std::filesystem::path& parent,
                                          std::error_code& error);
    ~Folder();
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    const std::filesystem::path& path() const { return m_path; }
    const std::filesystem::path& parent() const { return m_parent; }
    /// Another folder in it, for one output and the files that go with it.
    std::filesystem::path add_place(std::error_code& error);
    int place_count() const { return m_place_count; }

  private:
    Folder(std::filesystem::path parent, std::filesystem::path path, Descriptor lock);

    std::filesystem::path m_parent, m_path;
    Descriptor m_lock;
    int m_slot = -1;
    int m_place_count = 0;
};

/// Whether a path lies in a temporary folder of this process.
bool is_staged(const std::filesystem::path& path);

/// While one of these exists, end_process waits for its end: during commits, and while a folder is
/// made that end_process doesn't know yet.
class Commit {
  public:
    Commit();
    ~Commit();
    Commit(const Commit&) = delete;
    Commit& operator=(const Commit&) = delete;
};

}  // namespace pliant::staging
