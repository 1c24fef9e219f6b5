// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Short random sequences of operations on small scans, with each model of tissue, and a hash after
// each operation: the same on each instruction set, number of threads and machine (docs/developers/
// robustness.md). Scans and tools are made without functions of the C library's mathematics.
//
// The deformed scan is resampled after each operation, and rays are cast at it at the end.

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pliant::test {

struct OperationHash {
    std::string_view name;
    std::uint64_t hash;  ///< of the reports, the tissue and the deformed scan
    friend bool operator==(const OperationHash&, const OperationHash&) = default;
};

/// The sequence of a seed, on this thread alone.
std::vector<OperationHash> run_random_operations(std::uint64_t seed);

/// The instruction sets of this machine that the library was compiled for.
std::vector<std::int64_t> own_targets();

/// Vector code uses one of own_targets() while it lives, and the best one afterwards.
class OnTarget {
  public:
    explicit OnTarget(std::int64_t target);
    ~OnTarget();
    OnTarget(const OnTarget&) = delete;
    OnTarget& operator=(const OnTarget&) = delete;
};

/// Name of one of own_targets(): "AVX3", "AVX2", "SSE2", "SCALAR", …
std::string name_of_target(std::int64_t target);

}  // namespace pliant::test
