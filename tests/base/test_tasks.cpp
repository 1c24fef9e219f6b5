// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/core/tasks.h>

#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <stdexcept>
#include <thread>
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

/// Jobs of a host: each on a new thread, in reverse order, two at a time.
HostJobs backward_jobs(std::atomic<int>& jobs) {
    return {.thread_count = 2, .run = [&jobs](std::int64_t count, const auto& job) {
                for (std::int64_t n = count; n > 0; n -= 2) {
                    std::thread other([&] { job(n - 1); });
                    if (n > 1) job(n - 2);
                    other.join();
                    jobs += n > 1 ? 2 : 1;
                }
            }};
}

TEST(TaskArena, RunsItsLoopsAsJobsOfAHost) {
    std::atomic<int> jobs{0};
    const TaskArena arena(backward_jobs(jobs));
    EXPECT_EQ(arena.thread_count(), 2);
    for (const std::int64_t count : {0, 1, 9, 10, 11, 20, 95}) {
        jobs = 0;
        std::vector<int> visits(std::size_t(count), 0);
        std::atomic<bool> too_long{false};
        arena.for_each(count, 10, [&](std::int64_t begin, std::int64_t end) {
            if (end - begin > 10 || begin >= end) too_long = true;
            for (std::int64_t n = begin; n < end; ++n) ++visits[std::size_t(n)];
        });
        EXPECT_FALSE(too_long);
        EXPECT_EQ(visits, std::vector<int>(std::size_t(count), 1));
        EXPECT_EQ(jobs, count > 10 ? (count + 9) / 10 : 0) << count;
    }
}

TEST(TaskArena, GivesUpWhenTheHostDoesButNotWithinAJob) {
    for (const int threads : {1, 2}) {
        std::atomic<int> jobs{0}, polled{0};
        HostJobs host = backward_jobs(jobs);
        host.thread_count = threads;
        host.give_up = [&] { return ++polled == 3; };
        const TaskArena arena(std::move(host));
        std::atomic<int> visits{0};
        const auto visit = [&](std::int64_t, std::int64_t) {
            ++visits;
            if (threads > 1) arena.for_each(3, 1, [](std::int64_t, std::int64_t) {});
        };
        arena.for_each(5, 1, visit);
        arena.for_each(5, 1, visit);
        EXPECT_EQ(visits, 10);
        EXPECT_THROW(arena.for_each(5, 1, visit), std::bad_alloc);
        EXPECT_EQ(visits, 10);
        EXPECT_EQ(polled, 3);
    }
}

TEST(TaskArena, EndsALoopBetweenItsPartsIfTheHostGivesUpWithin) {
    for (const int threads : {1, 2}) {
        std::atomic<int> jobs{0};
        std::atomic<bool> is_over{false};
        HostJobs host = backward_jobs(jobs);
        host.thread_count = threads;
        host.give_up_within = [&] { return is_over.load(); };
        const TaskArena arena(std::move(host));
        std::atomic<int> visits{0};
        const auto visit = [&](std::int64_t, std::int64_t) { is_over = ++visits == 4; };
        EXPECT_FALSE(arena.gives_up());
        arena.for_each(4, 1, visit);
        EXPECT_TRUE(arena.gives_up());
        EXPECT_THROW(arena.for_each(4, 1, visit), std::bad_alloc);
        EXPECT_EQ(visits, 4);
        is_over = false;
        visits = 0;
        EXPECT_THROW(arena.for_each(20, 1, visit), std::bad_alloc);
        EXPECT_EQ(visits, 4);
    }
    EXPECT_FALSE(TaskArena(1).gives_up());
}

TEST(TaskArena, RethrowsAnExceptionOfAHostsJobAfterAllHaveEnded) {
    std::atomic<int> jobs{0};
    const TaskArena arena(backward_jobs(jobs));
    const auto fails = [](std::int64_t begin, std::int64_t) {
        if (begin == 4) throw std::runtime_error("four");
    };
    EXPECT_THROW(arena.for_each(20, 1, fails), std::runtime_error);
    EXPECT_EQ(jobs, 20);
    arena.for_each(20, 1, [](std::int64_t, std::int64_t) {});  // it goes on
    EXPECT_EQ(jobs, 40);
}

TEST(TaskArena, RunsALoopInsideOfAHostsJobOnThatThread) {
    std::atomic<int> jobs{0};
    const TaskArena arena(backward_jobs(jobs));
    std::atomic<int> visits{0};
    std::atomic<bool> elsewhere{false};
    arena.for_each(4, 1, [&](std::int64_t, std::int64_t) {
        const auto self = std::this_thread::get_id();
        arena.for_each(8, 1, [&](std::int64_t, std::int64_t) {
            ++visits;
            if (std::this_thread::get_id() != self) elsewhere = true;
        });
    });
    EXPECT_EQ(visits, 32);
    EXPECT_EQ(jobs, 4);
    EXPECT_FALSE(elsewhere);
}

TEST(TaskArena, TakesTheWholeMachineIfNotTold) {
    cpu_set_t processors;  // that this process may use
    ASSERT_EQ(::sched_getaffinity(0, sizeof processors, &processors), 0);
    EXPECT_EQ(TaskArena().thread_count(), CPU_COUNT(&processors));
}

}  // namespace
}  // namespace pliant
