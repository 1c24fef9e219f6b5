// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The one reader of files and folders. Streams, readdir() and predicates such as exists() report an
// error in the same way as an end or as an absence; these functions don't:
//
//     fewer bytes, get() == kEnd     the end, or an error: status() tells which
//     fault("ends early")            for a reader that needs more: the error of the system, if
//                                    there was one, or else its own message
//
// tools/check_files refuses other readers.

#pragma once

#include <pliant/result.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/descriptor.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// A regular file, read with a buffer. The first error stays: nothing is read after it.
class InputFile {
  public:
    static constexpr int kEnd = -1;

    /// Opens the file; never waits for a pipe or a device, which are errors.
    explicit InputFile(std::filesystem::path path);

    /// @returns Unreadable, which names the file, after an error of the system
    Status status() const;
    /// Error for a file that should go on: status(), or else Unreadable with this message.
    Error fault(const std::string& message) const;

    /// Length when it was opened [bytes]. 0 for files of /proc.
    std::uint64_t size() const { return m_size; }
    /// Offset of the next byte.
    std::uint64_t at() const { return m_begin + m_next; }
    void seek(std::uint64_t at);
    /// Reads one byte. @returns kEnd at the end and after an error
    int get() {
        if (m_next == m_count && !fill()) return kEnd;
        return static_cast<unsigned char>(m_buffer[m_next++]);
    }
    /// @returns number of bytes; fewer than count at the end and after an error
    std::size_t read(void* out, std::size_t count);
    /// Reads up to the end. @param expected  the kind of file, for errors
    /// @returns Unreadable for an error and for more than max_bytes, or LimitExceeded
    Result<std::string> read_rest(std::size_t max_bytes = std::string::npos,
                                  std::string_view expected = "a file");

  private:
    bool fill();
    void fail(const char* what, int error);

    std::filesystem::path m_path;
    std::string m_fault;  ///< empty: none
    Descriptor m_file;
    std::uint64_t m_size = 0, m_begin = 0;  ///< m_begin: offset of the buffer
    std::vector<char> m_buffer;
    std::size_t m_next = 0, m_count = 0;  ///< in the buffer
};

/// Names in a folder, sorted, without "." and "..". Unlike a directory_iterator, it doesn't end the
/// process if memory is short.
/// @returns Unreadable, which names the folder
Result<std::vector<std::string>> names_in(const std::filesystem::path& folder);

/// Kind of a file, with links followed. An absent file is not_found.
/// @returns Unreadable, which names the file, if the system can't tell
Result<std::filesystem::file_type> type_of(const std::filesystem::path& path);

}  // namespace pliant
#pragma GCC visibility pop
