// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Periodic timer with absolute wake-up times, so that errors don't accumulate. Missed periods are
// skipped, because two periods in a row would be felt.

#pragma once

#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <cerrno>
#include <cstdint>
#include <string>

namespace pliant {

inline std::int64_t steady_now_ns() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return std::int64_t(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

class Pace {
  public:
    explicit Pace(double rate_hz)
        : m_period_ns(std::int64_t(1e9 / rate_hz + 0.5)), m_next_ns(steady_now_ns()) {}

    /// Sleeps until the next period. @returns whether periods were skipped
    bool wait() {
        m_next_ns += m_period_ns;
        const std::int64_t now = steady_now_ns();
        const bool is_late = now > m_next_ns + m_period_ns;
        if (is_late) m_next_ns = now;
        const timespec until{time_t(m_next_ns / 1'000'000'000), long(m_next_ns % 1'000'000'000)};
        while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) continue;
        return is_late;
    }

  private:
    std::int64_t m_period_ns, m_next_ns;
};

/// Requests SCHED_FIFO for a thread. @returns an empty text, or the reason of a refusal and its
/// remedy
inline std::string ask_for_real_time(pthread_t thread, int priority) {
    if (priority <= 0) return "real-time priority: not asked for";
    sched_param parameter{};
    parameter.sched_priority = priority;
    const int error = pthread_setschedparam(thread, SCHED_FIFO, &parameter);
    if (error == 0) return {};
    return std::string("real-time priority ") + std::to_string(priority) + ": " +
           (error == EPERM ? "not permitted" : "not possible") +
           "; periods may be missed under load. Expected CAP_SYS_NICE, or a line '@audio - "
           "rtprio " +
           std::to_string(priority) + "' for your group in /etc/security/limits.conf";
}

}  // namespace pliant
