// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Lines of a text header, read no further than it goes. Files may be of any size and hold anything,
// so lines and headers are bounded.

#pragma once

#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

namespace pliant {

/// Longest header, and longest line of one, that are read [bytes]. 3D Slicer writes some 2 KiB for
/// each of a hundred segments; a key may hold a document.
inline constexpr std::size_t kMaxHeaderBytes = 1 << 20;
inline constexpr std::size_t kMaxHeaderLineBytes = 1 << 16;
/// Most pairs of key and value in a header.
inline constexpr std::size_t kMaxKeyValues = 1 << 14;

class HeaderLines {
  public:
    /// Keeps a reference to the path.
    explicit HeaderLines(const std::filesystem::path& path)
        : m_path(path), m_file(path, std::ios::binary) {}

    /// The next line without its end, which may be LF or CR LF; nothing at the end of the file.
    /// @returns Unreadable for a line or a header that is too long
    Result<std::optional<std::string>> next();
    /// Bytes of the lines so far, line ends included.
    std::uint64_t bytes_read() const { return m_bytes_read; }

  private:
    const std::filesystem::path& m_path;
    std::ifstream m_file;
    std::uint64_t m_bytes_read = 0;
    int m_number = 0;  ///< of the line
};

}  // namespace pliant
