// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The frame of every saved state (.plst), whichever tissue wrote it. Little-endian everywhere:
//
//     8  bytes  89 "PLST" 0d 0a 1a: detects transfers in text mode
//     4  u32    version
//     4  u32    flags
//     8  u64    length of the file
//     …         content
//     8  u64    checksum of everything before it

#pragma once

#include <pliant/core/vec.h>
#include <pliant/result.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

using Bytes = std::vector<std::byte>;

/// Flag of a state that is a list of numbers (tissue/node_tissue.cpp). Other flags belong to
/// ChainMail (chainmail/state_file.cpp).
inline constexpr std::uint32_t kStateOfNumbers = 1 << 8;

class StateWriter {
  public:
    explicit StateWriter(std::uint32_t flags);
    void put(std::span<const std::byte> bytes);
    void put_u32(std::uint32_t value);
    void put_u64(std::uint64_t value);
    void put_double(double value);
    void put_vector(Vec3d v);
    /// Completes the frame. @returns the whole file
    Bytes finish();

  private:
    Bytes m_out;
};

/// Bounds-checked reader. All take… return false at the end of the content.
class StateParser {
  public:
    /// Checks the frame. @param name   of the file, for messages
    /// @param known_flags  others are damage
    /// @returns Unreadable; Unsupported if a newer Pliant wrote it
    static Result<StateParser> open(std::string name, std::span<const std::byte> file,
                                    std::uint32_t known_flags);

    std::uint32_t flags() const { return m_flags; }
    const std::string& name() const { return m_name; }
    /// Bytes that are not yet read.
    std::size_t left() const { return m_bytes.size(); }
    bool take(std::size_t count, std::span<const std::byte>& out);
    bool take_u32(std::uint32_t& value);
    bool take_u64(std::uint64_t& value);
    bool take_double(double& value);
    bool take_vector(Vec3d& v);
    Error damaged() const;

  private:
    StateParser(std::string name, std::span<const std::byte> bytes)
        : m_name(std::move(name)), m_bytes(bytes) {}

    std::string m_name;
    std::span<const std::byte> m_bytes;
    std::uint32_t m_flags = 0;
};

}  // namespace pliant
#pragma GCC visibility pop
