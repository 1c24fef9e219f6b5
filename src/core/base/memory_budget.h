// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Limit on a reader's memory. Linux overcommits memory and kills processes that use it, so large
// requests are compared with the available memory beforehand. In a container that is the control
// group's share, not the machine's.

#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

inline constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

/// Sources of the kernel's information. Tests use separate folders.
struct MemorySources {
    std::filesystem::path root = "/";  ///< of proc/ and sys/
    /// Limit of the address space [bytes]; proc/self/statm has the used part.
    std::uint64_t address_space_limit = kUnlimited;

    static MemorySources of_this_process();
};

/// Bytes that this process may still use: the minimum of the machine's available memory, the room
/// under the limit of each control group above it (version 1 and 2; reclaimable page cache counts
/// as room) and the rest of its address space. Unreadable sources impose no limit.
std::uint64_t available_memory(const MemorySources& sources);

/// Whether so much more memory is available. Small requests are never refused.
bool has_memory_for(std::uint64_t bytes);

/// Replaces the sources of has_memory_for during its lifetime, for tests.
class UseMemorySources {
  public:
    explicit UseMemorySources(const MemorySources& sources);
    ~UseMemorySources();
    UseMemorySources(const UseMemorySources&) = delete;
    UseMemorySources& operator=(const UseMemorySources&) = delete;
};

}  // namespace pliant
#pragma GCC visibility pop
