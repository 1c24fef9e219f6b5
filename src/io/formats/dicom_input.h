// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bytes of a DICOM file. Those of a deflated one are inflated in memory from a position on:
//
//     preamble, group 2 │ deflated elements          the file
//     preamble, group 2 │ elements …                 the bytes that are read
//                       └ deflated_from

#pragma once

#include "base/input_file.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace pliant {

class DicomInput {
  public:
    explicit DicomInput(std::filesystem::path path);

    /// Inflates the bytes from a position on.
    /// @returns Unreadable if they are damaged, LimitExceeded if they are more than 1 GiB
    Status inflate_from(std::uint64_t start);

    const std::filesystem::path& path() const { return m_path; }
    /// Error of reading, after which no more bytes are read.
    Status status() const { return m_file.status(); }
    /// Error for a file that should go on, as InputFile::fault.
    Error fault(const std::string& message) const { return m_file.fault(message); }
    std::uint64_t size() const;
    std::uint64_t at() const { return m_at; }
    void seek(std::uint64_t at) { m_at = at; }
    /// @returns number of bytes; fewer than count at the end and after an error
    std::size_t read(void* out, std::size_t count);

  private:
    std::filesystem::path m_path;
    InputFile m_file;
    std::uint64_t m_at = 0;
    std::optional<std::uint64_t> m_deflated_from;
    std::string m_inflated;
};

}  // namespace pliant
