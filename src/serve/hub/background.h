// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Work on a thread of its own, whose result is taken in a later step.

#pragma once

#include <pliant/result.h>

#include <atomic>
#include <thread>
#include <utility>

#include "base/errors.h"

namespace pliant::serve {

template <class T>
class Background {
  public:
    /// @param work  Result<T>(const std::stop_token&)
    template <class Work>
    explicit Background(Work work)
        : m_thread([this, work = std::move(work)](const std::stop_token& stop) mutable {
              m_result = attempt([&] { return work(stop); });
              m_is_done.store(true, std::memory_order_release);
          }) {}

    bool is_done() const { return m_is_done.load(std::memory_order_acquire); }
    /// @pre is_done()
    Result<T>& result() { return m_result; }
    /// The work ends soon.
    void cancel() { m_thread.request_stop(); }

  private:
    Result<T> m_result = out_of_memory();
    std::atomic<bool> m_is_done = false;
    std::jthread m_thread;  // declared last, so that it ends first
};

}  // namespace pliant::serve
