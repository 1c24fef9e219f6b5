// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Outputs that appear together or not at all: each file is written under a temporary folder beside
// its place, and all are renamed when everything is written and on the disk.
//
//     StagedFiles files;
//     const auto picture = files.stage("view.png");         // .pliant-out-Xa81Qe/0/view.png
//     …                                                     // written there
//     const Status done = files.commit();                   // view.png
//
// A process that is killed leaves old files or new ones, and a temporary folder. The next one that
// stages a file there removes it; where the kill fell into a commit of several files, it finishes
// the commit. Temporary folders of living processes are locked, and left alone.

#pragma once

#include <pliant/result.h>

#include <filesystem>
#include <memory>
#include <string>

#pragma GCC visibility push(default)
namespace pliant {

class StagedFiles {
  public:
    StagedFiles();
    StagedFiles(const StagedFiles&) = delete;
    StagedFiles& operator=(const StagedFiles&) = delete;
    /// Removes staged files that were not committed.
    ~StagedFiles();

    /// Where to write the file that shall become target. The name stays the same, so formats that
    /// name a second file (.nhdr and its data) can be staged too. A symbolic link is followed: the
    /// file that it names is written. `-`, /dev/stdout, /dev/fd/N, pipes and character devices are
    /// written to at the commit, and never replaced. A target that is itself a staged path is
    /// returned as it is: the object that staged it commits it.
    /// @returns Unwritable if target's folder is missing, is no folder, or can't be written
    Result<std::filesystem::path> stage(const std::filesystem::path& target);

    /// A folder in which to write any number of files that shall be in the folder target, which is
    /// made if it isn't there; other files there stay.
    /// @returns Unwritable likewise
    Result<std::filesystem::path> stage_folder(const std::filesystem::path& target);

    /// Writes to streams, then renames everything to its place. Data files go before the headers
    /// that name them.
    /// @returns Unwritable, and the files are as they were
    Status commit();

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

/// A message about staged files, as one about their places.
std::string about_places(std::string message);

/// Called with one line of text when a commit of an earlier process was finished or taken back, or
/// could not be.
using RecoveryListener = void (*)(const char* line);
/// @returns the listener that was set before; at first there is none
RecoveryListener set_recovery_listener(RecoveryListener listener) noexcept;
RecoveryListener recovery_listener() noexcept;

/// Removes all staged files and ends the process at once, without destructors. For signal handlers
/// and terminate handlers of programs; async-signal-safe. During a commit it returns, and the
/// commit ends the process when it is done.
void end_process(int status) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
