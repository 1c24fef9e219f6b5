// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A file that is written piece by piece.

#pragma once

#include <pliant/result.h>

#include <filesystem>
#include <string>
#include <string_view>

#pragma GCC visibility push(default)
namespace pliant {

/// A new file that is written piece by piece. Unlike a stream, it tells why it failed: nothing is
/// written after the first error, which stays. Interrupted calls go on.
class OutputFile {
  public:
    /// Opens the file; one of this name is overwritten.
    /// @param name  for errors; empty: the path
    explicit OutputFile(const std::filesystem::path& path, const std::string& name = {});
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;
    ~OutputFile();

    void write(std::string_view bytes);
    /// @returns Unwritable, which names the file
    Status status() const;
    /// Writes the rest and closes the file; without it, the rest is missing. @returns status()
    Status close();

  private:
    void flush();

    std::string m_name, m_buffer;
    int m_file, m_error = 0;
};

}  // namespace pliant
#pragma GCC visibility pop
