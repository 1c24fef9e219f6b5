// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// As each_allocation.h, for functions that change nothing and return something new.

#pragma once

#include "support/each_allocation.h"

namespace pliant::test {

/// Lets a function that makes something new fail at each allocation, and expects LimitExceeded.
template <class Make>
Failures fail_each_allocation_of(const Make& make, const EachAllocation& options = {}) {
    Failures failures;
    const std::int64_t first = allocation_count();
    const bool succeeds = make().ok();
    failures.allocations = allocation_count() - first;
    EXPECT_TRUE(succeeds);
    for (const std::int64_t n : chosen(failures.allocations, options)) {
        SCOPED_TRACE("seed " + std::to_string(options.seed) + ", allocation " + std::to_string(n));
        ErrorCode code = ErrorCode::LimitExceeded;
        bool ok = false;
        {
            const FailingAllocation failing(n);
            const auto result = make();
            ok = result.ok();
            if (!ok) code = result.error().code;
        }
        EXPECT_EQ(code, ErrorCode::LimitExceeded);
        failures.failed += !ok;
    }
    EXPECT_GT(failures.failed, 0);
    return failures;
}

}  // namespace pliant::test
