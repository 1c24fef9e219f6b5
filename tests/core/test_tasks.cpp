// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/tasks.h>

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace pliant {
namespace {

TEST(TaskArena, CoversEveryIndexOnceWithPiecesNoLongerThanTheGrain) {
    for (const int threads : {1, 2, 4}) {
        const TaskArena arena(threads);
        EXPECT_EQ(arena.thread_count(), threads);
        for (const std::int64_t count : {0, 1, 9, 10, 11, 1000}) {
            std::vector<int> visits(std::size_t(count), 0);
            std::atomic<bool> too_long{false};
            arena.for_each(count, 10, [&](std::int64_t begin, std::int64_t end) {
                if (end - begin > 10 || begin >= end) too_long = true;
                for (std::int64_t n = begin; n < end; ++n) ++visits[std::size_t(n)];
            });
            EXPECT_FALSE(too_long);
            EXPECT_EQ(visits, std::vector<int>(std::size_t(count), 1));
        }
    }
}

TEST(TaskArena, TakesTheWholeMachineIfNotTold) {
    EXPECT_GE(TaskArena().thread_count(), 1);
}

}  // namespace
}  // namespace pliant
