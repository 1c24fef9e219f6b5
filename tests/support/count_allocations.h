// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Counts allocations, and lets one fail: a program that names count_allocations.cpp gets an
// operator new that does.

#pragma once

#include <cstddef>
#include <cstdint>

namespace pliant::test {

/// Calls of operator new so far, on all threads.
std::int64_t allocation_count();

/// While it exists, the n-th call of operator new, on any thread, and every later one throw
/// std::bad_alloc (the nothrow form returns null).
class FailingAllocation {
  public:
    /// @param n             0: the next one
    /// @param fewest_bytes  smaller ones succeed, and don't count
    explicit FailingAllocation(std::int64_t n, std::size_t fewest_bytes = 0);
    ~FailingAllocation();
    FailingAllocation(const FailingAllocation&) = delete;
    FailingAllocation& operator=(const FailingAllocation&) = delete;
    /// Whether the n-th call has come.
    bool has_failed() const;
};

}  // namespace pliant::test
