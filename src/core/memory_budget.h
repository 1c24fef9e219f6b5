// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// How much memory a reader may ask for. Linux promises more than it has, and ends a process that
// takes the promise at its word; so large requests are held against the memory left before they are
// made. In a container that is its control group's share, not the machine's.

#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

inline constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

/// Where the kernel says it. Tests have folders of their own.
struct MemorySources {
    std::filesystem::path root = "/";  ///< of proc/ and sys/
    /// Limit of the address space [bytes], of which proc/self/statm says how much is in use.
    std::uint64_t address_space_limit = kUnlimited;

    static MemorySources of_this_process();
};

/// Bytes that this process may still take: the least of the machine's available memory, the room
/// under the limit of each control group above it (version 1 and 2; pages of files that can be
/// given back count as room) and the rest of its address space. What can't be read limits nothing.
std::uint64_t available_memory(const MemorySources& sources);

/// Whether so much more can be had now. Small requests are never refused.
bool has_memory_for(std::uint64_t bytes);

/// While one lives, has_memory_for asks other sources: for tests.
class UseMemorySources {
  public:
    explicit UseMemorySources(const MemorySources& sources);
    ~UseMemorySources();
    UseMemorySources(const UseMemorySources&) = delete;
    UseMemorySources& operator=(const UseMemorySources&) = delete;
};

}  // namespace pliant
#pragma GCC visibility pop
