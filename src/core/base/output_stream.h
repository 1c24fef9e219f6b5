// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Outputs other than regular files: standard output, pipes, character devices.

#pragma once

#include <pliant/result.h>

#include <filesystem>
#include <optional>

namespace pliant {

/// File descriptor named by /dev/stdout, /dev/stderr, /dev/fd/N or /proc/self/fd/N.
std::optional<int> descriptor_of(const std::filesystem::path& path);

class OutputStream {
  public:
    /// @param is_standard_output  true for every path
    /// @returns nullopt unless path names a descriptor, a pipe or a character device
    static std::optional<OutputStream> of(const std::filesystem::path& path,
                                          bool is_standard_output);

    /// @returns Unwritable for a descriptor that is closed or read-only
    Status check() const;
    /// Copies a file to the stream. Waits up to two seconds for a pipe's reader.
    Status write(const std::filesystem::path& file) const;

  private:
    explicit OutputStream(std::filesystem::path path, int descriptor)
        : m_path(std::move(path)), m_descriptor(descriptor) {}

    std::filesystem::path m_path;
    int m_descriptor;  ///< −1: the path is opened
};

}  // namespace pliant
