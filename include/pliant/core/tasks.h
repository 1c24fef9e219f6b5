// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Threads for data-parallel loops. The program creates one arena and passes it to the calls; the
// library starts no other threads for them. Results never depend on the number of threads.

#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#pragma GCC visibility push(default)
namespace pliant {

/// The job system of a host program, to be used instead of threads of the library.
struct HostJobs {
    int thread_count = 1;  ///< jobs that can run at the same time, 1 or more
    /// Calls job(n) for every n of 0…count − 1, on any threads and in any order, and returns when
    /// all calls have ended. Jobs don't throw.
    std::function<void(std::int64_t count, const std::function<void(std::int64_t n)>& job)> run{};
    /// Polled at each loop, on the thread that begins it; true ends the call as if memory had run
    /// out: LimitExceeded, and nothing has changed. It must be false in calls that can't fail. May
    /// be empty.
    std::function<bool()> give_up{};
    /// Likewise, but polled between the parts of a loop, on all threads at the same time. For calls
    /// that change nothing, such as pictures: others may be in the middle of a change.
    std::function<bool()> give_up_within{};
};

/// Thread safety: any call on any thread.
class TaskArena {
  public:
    /// @param thread_count  0: all hardware threads
    explicit TaskArena(int thread_count = 0);
    /// Runs all loops as jobs of the host. A loop inside of a job runs on the job's thread.
    explicit TaskArena(HostJobs jobs);
    ~TaskArena();
    TaskArena(TaskArena&&) noexcept;
    TaskArena& operator=(TaskArena&&) noexcept;

    int thread_count() const;
    /// Polls HostJobs::give_up_within. For long work inside of a loop's part.
    bool gives_up() const;

    /// Calls body(begin, end) for ranges of 0…count, each at most grain long, on all threads, and
    /// waits for them. An exception of the body is rethrown after all running ranges have ended;
    /// the others may be skipped.
    void for_each(std::int64_t count, std::int64_t grain,
                  const std::function<void(std::int64_t begin, std::int64_t end)>& body) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
