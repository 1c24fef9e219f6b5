// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// An operation of a tissue that ran out of memory leaves no trace: neither in the tissue's state,
// nor in the results of later operations.

#pragma once

#include <pliant/resample.h>
#include <pliant/tissue.h>

#include <cstdint>
#include <tuple>
#include <vector>

#include "support/each_allocation.h"

namespace pliant::test {

constexpr std::uint32_t kFirstTool = 3, kSecondTool = 4;

/// One push with the first tool, and one sweep.
inline void touch(Tissue& tissue, const Push& push) {
    tissue.begin_group("push");
    EXPECT_TRUE(tissue.push(kFirstTool, push).ok());
    EXPECT_TRUE(tissue.sweep().ok());
    EXPECT_EQ(tissue.end_group(), 0);
}

inline auto visible_state(const Tissue& tissue) {
    return std::tuple(tissue.hash(), tissue.is_touched_by(kFirstTool),
                      tissue.is_touched_by(kSecondTool), tissue.undo_steps());
}

/// Hashes of the next sweeps, and after both tools have let go.
/// @param sweeps  after the tools have let go
inline std::vector<std::uint64_t> later_hashes(Tissue& tissue, int sweeps) {
    std::vector<std::uint64_t> hashes;
    for (int n = 0; n < 3; ++n) {
        EXPECT_TRUE(tissue.sweep().ok());
        hashes.push_back(tissue.hash());
    }
    hashes.push_back(hash_volume(deform_volume(tissue).value().volume));
    tissue.release(kFirstTool);
    tissue.release(kSecondTool);
    for (int n = 0; n < sweeps; ++n) (void)tissue.sweep();
    hashes.push_back(tissue.hash());
    return hashes;
}

/// Expects that an operation fails at each of its allocations, and leaves no trace.
/// @param make    a pointer to a new tissue, in the same state each time
/// @param least   failures that are expected at least
/// @param sweeps  of later_hashes
template <class Make, class Operation>
void expect_no_trace(const char* name, const Make& make, const Operation& operation, int least,
                     int sweeps = 30) {
    SCOPED_TRACE(name);
    const auto state = [](const auto& tissue) { return visible_state(tissue); };
    const Failures failures = fail_each_allocation(make, operation, state, {.fresh = true});
    EXPECT_GE(failures.failed, least);
    const std::vector<std::uint64_t> expected = later_hashes(*make(), sweeps);
    for (const std::int64_t n :
         chosen(failures.allocations, {.all_up_to = 25, .of_the_rest = 10})) {
        auto tissue = make();
        bool ok = false;
        {
            const FailingAllocation failing(n);
            ok = operation(*tissue).ok();
        }
        if (!ok) {
            ASSERT_EQ(later_hashes(*tissue, sweeps), expected) << "allocation " << n;
        }
    }
}

}  // namespace pliant::test
