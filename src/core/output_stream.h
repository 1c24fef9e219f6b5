// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Outputs that are no files to be replaced: standard output, pipes, character devices.

#pragma once

#include <pliant/result.h>

#include <filesystem>
#include <optional>

namespace pliant {

/// The file descriptor that /dev/stdout, /dev/stderr, /dev/fd/N or /proc/self/fd/N stands for.
std::optional<int> descriptor_of(const std::filesystem::path& path);

class OutputStream {
  public:
    /// @param is_standard_output  true for any path
    /// @returns nothing if path is neither a descriptor's name, nor a pipe or character device
    static std::optional<OutputStream> of(const std::filesystem::path& path,
                                          bool is_standard_output);

    /// @returns Unwritable, for a descriptor that is closed or only read
    Status check() const;
    /// Writes all of a file. A pipe without a reader is waited for, for two seconds.
    Status write(const std::filesystem::path& file) const;

  private:
    explicit OutputStream(std::filesystem::path path, int descriptor)
        : m_path(std::move(path)), m_descriptor(descriptor) {}

    std::filesystem::path m_path;
    int m_descriptor;  ///< −1: the path is opened
};

}  // namespace pliant
