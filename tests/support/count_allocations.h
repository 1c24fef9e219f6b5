// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Counts allocations: a program that names count_allocations.cpp gets an operator new that does.

#pragma once

#include <cstdint>

namespace pliant::test {

/// Calls of operator new so far, on all threads.
std::int64_t allocation_count();

}  // namespace pliant::test
