// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// An open file of the system, and complete reads and writes with it: interrupted calls go on.
// Errors are errno; 0 is success.

#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <utility>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

class Descriptor {
  public:
    explicit Descriptor(int number = -1) : m_number(number) {}
    ~Descriptor() { (void)close(); }
    Descriptor(Descriptor&& other) noexcept : m_number(other.release()) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(m_number, other.m_number);
        return *this;
    }

    int number() const { return m_number; }
    bool is_open() const { return m_number >= 0; }
    int release() { return std::exchange(m_number, -1); }
    int close() noexcept;

  private:
    int m_number;
};

/// Opens a file that programs started later don't inherit. @param flags  of open()
Descriptor open_file(const std::filesystem::path& path, int flags, unsigned mode = 0) noexcept;

/// Waits for descriptors that don't block. @param[out] written  bytes; may be null
int write_all(int descriptor, const void* bytes, std::size_t count,
              std::size_t* written = nullptr) noexcept;
/// @param[out] read  bytes, fewer than count at the end of the file or after an error
int read_at(int descriptor, void* out, std::size_t count, std::uint64_t offset,
            std::size_t* read) noexcept;

/// Locks a file or folder against other programs, until it is closed.
/// @returns false if another program holds it
bool try_lock(int descriptor) noexcept;
/// Syncs a file's data to the disk.
int sync_data(int descriptor) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
