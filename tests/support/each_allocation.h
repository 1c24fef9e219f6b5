// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Runs an operation while its n-th allocation and all later ones fail, for n = 0, 1, 2, …, until it
// succeeds.

#pragma once

#include <gtest/gtest.h>
#include <pliant/result.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "support/count_allocations.h"
#include "support/random.h"

namespace pliant::test {

struct EachAllocation {
    int all_up_to = 300;     ///< each of the first ones fails
    int of_the_rest = 60;    ///< number of the others that fail, drawn at random
    std::uint64_t seed = 1;  ///< of that
    bool fresh = false;      ///< a new object each time: earlier attempts leave no memory
};

/// Which of some allocations fail, in order.
inline std::vector<std::int64_t> chosen(std::int64_t count, const EachAllocation& options) {
    std::vector<std::int64_t> numbers;
    for (std::int64_t n = 0; n < std::min<std::int64_t>(count, options.all_up_to); ++n)
        numbers.push_back(n);
    Random random(options.seed);
    const auto rest = count - std::int64_t(numbers.size());
    for (std::int64_t k = 0; k < std::min<std::int64_t>(rest, options.of_the_rest); ++k)
        numbers.push_back(options.all_up_to +
                          std::int64_t(random.real(0, 1) * double(rest)) % rest);
    std::sort(numbers.begin(), numbers.end());
    return numbers;
}

/// Result of an operation with a failing allocation.
struct Failures {
    std::int64_t allocations = 0;  ///< of the operation on the twin
    int failed = 0;                ///< times that it returned an error
};

/// Lets an operation fail at each allocation that it makes on a twin, and expects LimitExceeded and
/// the same state as before. In the end it succeeds, and expects the twin's state.
/// @param make       a pointer to a new object, in the same state each time
/// @param operation  on an object; returns a Result
/// @param state      of an object, to be compared
template <class Make, class Operation, class State>
Failures fail_each_allocation(const Make& make, const Operation& operation, const State& state,
                              const EachAllocation& options = {}) {
    Failures failures;
    auto twin = make(), object = make();
    const auto before = state(*object);
    EXPECT_EQ(state(*twin), before) << "before anything failed";
    const std::int64_t first = allocation_count();
    const bool twin_succeeds = operation(*twin).ok();
    failures.allocations = allocation_count() - first;
    EXPECT_TRUE(twin_succeeds);
    const auto after = state(*twin);
    SCOPED_TRACE("seed " + std::to_string(options.seed));
    for (const std::int64_t n : chosen(failures.allocations, options)) {
        SCOPED_TRACE("allocation " + std::to_string(n));
        bool has_failed = false, succeeds = false;
        ErrorCode code = ErrorCode::LimitExceeded;
        {
            const FailingAllocation failing(n);
            const auto result = operation(*object);
            has_failed = failing.has_failed();
            succeeds = result.ok();
            if (!succeeds) code = result.error().code;
        }
        EXPECT_EQ(code, ErrorCode::LimitExceeded);
        EXPECT_TRUE(has_failed || succeeds);
        EXPECT_EQ(state(*object), succeeds ? after : before);
        if (::testing::Test::HasFailure()) return failures;
        if (!succeeds) {
            ++failures.failed;
            if (options.fresh) object = make();
        } else if (has_failed) {
            object = make();  // it could do without that allocation
        } else {
            break;  // an earlier attempt has left it the memory
        }
    }
    if (state(*object) == before) {
        EXPECT_TRUE(operation(*object).ok());
    }
    EXPECT_EQ(state(*object), after) << "after the failures";
    EXPECT_GT(failures.failed, 0);
    return failures;
}

}  // namespace pliant::test
