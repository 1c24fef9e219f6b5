// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Counts a thread's allocations and locks, which could make it wait.

#pragma once

#include <cstdint>

namespace pliant::test {

/// Starts counting on this thread.
void watch_this_thread();
std::int64_t allocations_of_this_thread();
std::int64_t locks_of_this_thread();
/// False with sanitizers, which have these functions for themselves.
bool can_watch_threads();

}  // namespace pliant::test
