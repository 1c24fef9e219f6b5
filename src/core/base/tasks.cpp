// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The only user of oneTBB.

#include <pliant/core/tasks.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <exception>
#include <mutex>
#include <new>
#include <optional>
#include <utility>

// ThreadSanitizer doesn't see the synchronisation in the system's uninstrumented oneTBB, so its
// fork and join are annotated here. oneTBB's templates must not be instrumented either, so this
// file isn't (src/CMakeLists.txt, which also sets PLIANT_TSAN). Races between pieces of one loop
// are still found, because the bodies are in other files.
#ifdef PLIANT_TSAN
#include <sanitizer/tsan_interface.h>
#endif

namespace pliant {
namespace {

void fork_happens_here([[maybe_unused]] void* token) {
#ifdef PLIANT_TSAN
    __tsan_release(token);
#endif
}
void join_happens_here([[maybe_unused]] void* token) {
#ifdef PLIANT_TSAN
    __tsan_acquire(token);
#endif
}

/// Whether this thread runs a job of a host.
thread_local bool is_in_job = false;

/// Runs ranges as jobs of the host, and rethrows the first exception of the body.
void run_on(const HostJobs& host, std::int64_t count, std::int64_t grain,
            const std::function<void(std::int64_t, std::int64_t)>& body) {
    std::atomic<bool> has_failed{false};
    std::mutex mutex;
    std::exception_ptr failure;
    const auto job = [&](std::int64_t n) {
        if (has_failed) return;
        is_in_job = true;
        try {
            if (host.give_up_within && host.give_up_within()) throw std::bad_alloc();
            body(n * grain, n < (count - 1) / grain ? (n + 1) * grain : count);
        } catch (...) {
            const std::lock_guard lock(mutex);
            if (!has_failed.exchange(true)) failure = std::current_exception();
        }
        is_in_job = false;
    };
    host.run((count - 1) / grain + 1, std::cref(job));
    if (failure) std::rethrow_exception(failure);
}

}  // namespace

struct TaskArena::Impl {
    std::optional<HostJobs> host;  ///< instead of oneTBB
    /// Allows more threads than cores, to which oneTBB otherwise limits itself.
    std::optional<tbb::global_control> more_threads_than_cores;
    tbb::task_arena arena;
};

TaskArena::TaskArena(int thread_count) : m_impl(std::make_unique<Impl>()) {
    if (thread_count > tbb::info::default_concurrency())
        m_impl->more_threads_than_cores.emplace(tbb::global_control::max_allowed_parallelism,
                                                std::size_t(thread_count));
    m_impl->arena.initialize(thread_count > 0 ? thread_count : tbb::task_arena::automatic);
}
TaskArena::TaskArena(HostJobs jobs) : m_impl(std::make_unique<Impl>()) {
    if (jobs.thread_count < 1) jobs.thread_count = 1;
    m_impl->host = std::move(jobs);
}
TaskArena::~TaskArena() = default;
TaskArena::TaskArena(TaskArena&&) noexcept = default;
TaskArena& TaskArena::operator=(TaskArena&&) noexcept = default;

int TaskArena::thread_count() const {
    return m_impl->host ? m_impl->host->thread_count : m_impl->arena.max_concurrency();
}

bool TaskArena::gives_up() const {
    return m_impl->host && m_impl->host->give_up_within && m_impl->host->give_up_within();
}

void TaskArena::for_each(std::int64_t count, std::int64_t grain,
                         const std::function<void(std::int64_t, std::int64_t)>& body) const {
    if (count <= 0) return;
    if (m_impl->host && m_impl->host->give_up && !is_in_job && m_impl->host->give_up())
        throw std::bad_alloc();
    if (count <= grain || thread_count() == 1 || is_in_job) {
        for (std::int64_t begin = 0; begin < count; begin += grain) {
            if (gives_up()) throw std::bad_alloc();
            body(begin, begin + grain < count ? begin + grain : count);
        }
        return;
    }
    if (m_impl->host) return run_on(*m_impl->host, count, grain, body);
    char fork = 0, join = 0;
    fork_happens_here(&fork);
    m_impl->arena.execute([&] {
        tbb::parallel_for(
            tbb::blocked_range<std::int64_t>(0, count, grain),
            [&](const tbb::blocked_range<std::int64_t>& range) {
                join_happens_here(&fork);
                body(range.begin(), range.end());
                fork_happens_here(&join);
            },
            tbb::simple_partitioner());
    });
    join_happens_here(&join);
}

}  // namespace pliant
