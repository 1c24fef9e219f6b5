// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// An ObjectSpace with failing allocations: the n-th of a call's allocations and all after it fail,
// for n = 0, 1, 2, … until it succeeds. A failure must leave the objects unchanged.

#include <gtest/gtest.h>
#include <pliant/research/objects.h>

#include <optional>

#include "chainmail/tissues.h"
#include "support/count_allocations.h"

namespace pliant::test {
namespace {

/// All n below a limit, followed by a random choice of the others.
constexpr std::int64_t kAllOf = 25;

/// Result of a call; nothing: success.
using Outcome = std::optional<ErrorCode>;

template <class T>
Outcome outcome(const Result<T>& result) {
    if (result.ok()) return std::nullopt;
    return result.error().code;
}

class ObjectsOutOfMemory : public ::testing::TestWithParam<int> {};

TEST_P(ObjectsOutOfMemory, LeavesObjectsInTheirSpaceAsTheyWere) {
    const TaskArena arena(GetParam());
    Random random(20261124);
    ChainMailSettings settings;
    settings.offset = 0.1;
    settings.max_movement_mm = 8;
    settings.bounded = true;
    settings.history_max_steps = 10;
    Volume beside = block({8, 8, 8});
    beside.grid.origin_mm = {17, 0, 0};
    ObjectSpace space(arena);
    ASSERT_TRUE(space.add_object(block({8, 8, 8}), settings, true).ok());
    const std::vector<Vec3i> elements = {{3, 3, 3}, {4, 4, 4}};
    const auto hash = [&] { return space.object(0).hash() ^ std::uint64_t(space.object_count()); };
    const auto fail_each = [&](const auto& run) {
        const std::uint64_t before = hash();
        for (std::int64_t n = 0;; n += n < kAllOf ? 1 : random.whole(1, 1 + int(n / 3))) {
            Outcome outcome;
            bool has_failed = false;
            Volume scan = beside;
            {
                const FailingAllocation failing(n);
                outcome = run(std::move(scan));
                has_failed = failing.has_failed();
            }
            if (!has_failed) {
                EXPECT_FALSE(outcome);
                EXPECT_NE(hash(), before);
                return n;
            }
            EXPECT_EQ(outcome, ErrorCode::LimitExceeded) << n;
            EXPECT_EQ(hash(), before) << n;
            if (HasFailure()) return n;
        }
    };
    EXPECT_GT(fail_each([&](Volume scan) {
                  return outcome(space.add_object(std::move(scan), settings, false));
              }),
              10);
    for (const Vec3d push_mm : {Vec3d{2, 1, 0}, Vec3d{150, -130, 20}, Vec3d{-40, 30, 0}})
        EXPECT_GT(
            fail_each([&](Volume) { return outcome(space.push_elements(0, elements, push_mm)); }),
            0);
}

INSTANTIATE_TEST_SUITE_P(Threads, ObjectsOutOfMemory, ::testing::Values(1, 2));

}  // namespace
}  // namespace pliant::test
