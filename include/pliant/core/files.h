// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Atomic output of several files. Each file is written to a temporary folder beside its target. All
// are renamed once everything is written and synced to the disk.
//
// @code
//   StagedFiles files;
//   const auto picture = files.stage("view.png");  // .pliant-out-Xa81Qe/0/view.png
//   if (!picture || !render(*picture).ok()) return;
//   const Status done = files.commit();            // view.png
// @endcode
//
// A process that is killed leaves old or new files, and a temporary folder. The next process that
// stages a file there removes the folder, or completes an interrupted commit. Temporary folders of
// living processes are locked and not touched.

#pragma once

#include <pliant/result.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#pragma GCC visibility push(default)
namespace pliant {

/// Thread safety: one thread.
class StagedFiles {
  public:
    StagedFiles();
    StagedFiles(const StagedFiles&) = delete;
    StagedFiles& operator=(const StagedFiles&) = delete;
    /// Removes staged files that were not committed.
    ~StagedFiles();

    /// Returns the temporary path for a target. The file name stays the same, so formats that name
    /// a second file (.nhdr and its data) can be staged too. A symbolic link is followed to the
    /// file that it names. `-`, /dev/stdout, /dev/fd/N, pipes and character devices are written to
    /// at the commit, and never replaced. A target that is itself a staged path is returned
    /// unchanged: the object that staged it commits it.
    /// @returns Unwritable if target's folder is missing, not a folder, or not writable
    Result<std::filesystem::path> stage(const std::filesystem::path& target);

    /// Returns a temporary folder for any number of files of the folder target. The commit creates
    /// target if needed; other files in it stay.
    /// @returns Unwritable as stage()
    Result<std::filesystem::path> stage_folder(const std::filesystem::path& target);

    /// Writes to streams, then renames all files to their targets. Data files precede the headers
    /// that name them.
    /// @returns Unwritable, and all files are unchanged
    Status commit();

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

/// Replaces staged paths in a message by their targets.
std::string about_targets(std::string message);

/// Called with one line of text when a commit of an earlier process was completed, rolled back, or
/// couldn't be.
using RecoveryListener = void (*)(const char* line);
/// Replaces the listener. @returns the previous one, initially null
RecoveryListener set_recovery_listener(RecoveryListener listener) noexcept;
RecoveryListener recovery_listener() noexcept;

/// Removes all staged files and ends the process immediately, without destructors. For signal
/// handlers and terminate handlers of programs; async-signal-safe. During a commit it returns, and
/// the commit ends the process when it is done.
void end_process(int status) noexcept;

// Small text files from outside: settings, scenes, curves, logs. They are read as a whole. Their
// nesting is checked before a parser runs, because parsers recurse.

/// Refuses folders, pipes, sockets, devices and circular links, without opening them.
/// @param expected  the kind of file, for errors: "a settings file"
/// @returns NotFound, or Unreadable
Status check_is_file(const std::filesystem::path& path, std::string_view expected);

/// Reads a whole file.
/// @returns an error of check_is_file; Unreadable for more than max_bytes
Result<std::string> read_small_file(const std::filesystem::path& path, std::size_t max_bytes,
                                    std::string_view expected);
inline constexpr std::size_t kMaxSmallFileBytes = std::size_t(16) << 20;

enum class TextSyntax { Toml, Json };

/// Checks the nesting of a text. Parsers, and destructors of their results, recurse once per level.
/// A text deeper than every format of Pliant is refused: more than 64 nested brackets, or 32 dots
/// in a TOML key. Brackets and dots in strings and comments don't count.
/// @returns Unreadable, which names the line but no file
Status check_nesting(std::string_view text, TextSyntax syntax);

/// Quotes a text from a file in a message: its printable ASCII characters, '?' for the others, at
/// most 60.
std::string shown(std::string_view text);

/// Makes a text safe for a terminal: line ends become spaces; other control characters and broken
/// UTF-8 become '?'.
/// @param max_bytes  longer texts are truncated with an ellipsis
std::string printable(std::string_view text, std::size_t max_bytes = std::string_view::npos);

/// Makes a whole message printable; if it is longer than 400 bytes, its middle is left out.
std::string one_line(std::string_view message);

}  // namespace pliant
#pragma GCC visibility pop
