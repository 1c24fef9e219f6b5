// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Threads for data-parallel loops. One arena is made by the program and lent to every call that can
// use it; nothing in the library starts threads of its own. Results never depend on the number of
// threads.

#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#pragma GCC visibility push(default)
namespace pliant {

class TaskArena {
  public:
    /// @param thread_count  0: as many as the machine has
    explicit TaskArena(int thread_count = 0);
    ~TaskArena();
    TaskArena(TaskArena&&) noexcept;
    TaskArena& operator=(TaskArena&&) noexcept;

    int thread_count() const;

    /// Calls body(begin, end) for pieces of 0…count, each at most grain long, on all threads, and
    /// returns when all are done. An exception of the body is passed on when no piece runs
    /// any more; pieces may be left out then.
    void for_each(std::int64_t count, std::int64_t grain,
                  const std::function<void(std::int64_t begin, std::int64_t end)>& body) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
