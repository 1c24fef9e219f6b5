// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Reader of a text header's lines. Files may have any size and content, so the length of lines and
// headers is bounded.

#pragma once

#include "base/input_file.h"

#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace pliant {

/// Maximum length of a header, and of a header line [bytes]. 3D Slicer writes some 2 KiB for each
/// of a hundred segments; a key may contain a document.
inline constexpr std::size_t kMaxHeaderBytes = 1 << 20;
inline constexpr std::size_t kMaxHeaderLineBytes = 1 << 16;
/// Maximum number of key/value pairs in a header.
inline constexpr std::size_t kMaxKeyValues = 1 << 14;

class HeaderLines {
  public:
    /// Keeps a reference to the path.
    explicit HeaderLines(const std::filesystem::path& path) : m_path(path), m_file(path) {}

    /// Reads the next line without its end (LF or CR LF); nullopt at the end of the file.
    /// @returns Unreadable for an error of reading, and a line or a header that is too long
    Result<std::optional<std::string>> next();
    /// Bytes of the lines so far, line ends included.
    std::uint64_t bytes_read() const { return m_bytes_read; }

  private:
    const std::filesystem::path& m_path;
    InputFile m_file;
    std::uint64_t m_bytes_read = 0;
    int m_number = 0;  ///< line number
};

}  // namespace pliant
