// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Seeds of a property test: a fixed few in every run, others by hand.

#pragma once

#include <cstdint>
#include <cstdlib>

namespace pliant::test {

/// Instances of a property test. PLIANT_SEED and PLIANT_INSTANCES replace the defaults, for longer
/// searches by hand.
struct Search {
    std::uint64_t first_seed = 0;
    int instances = 0;
    bool is_by_hand = false;  ///< PLIANT_INSTANCES is given

    Search(std::uint64_t default_seed, int default_instances)
        : first_seed(default_seed), instances(default_instances) {
        if (const char* given = std::getenv("PLIANT_SEED"))
            first_seed = std::strtoull(given, nullptr, 10);
        if (const char* given = std::getenv("PLIANT_INSTANCES")) {
            instances = std::atoi(given);
            is_by_hand = true;
        }
    }
    std::uint64_t seed(int instance) const { return first_seed + std::uint64_t(instance); }
};

}  // namespace pliant::test
