// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A loop over the members of an arena: in parallel if there are enough of them for all threads;
// else one by one, whose own loops are then the parallel part.

#pragma once

#include <pliant/core/tasks.h>

#include <cstddef>
#include <optional>
#include <vector>

#include "base/errors.h"

namespace pliant::gym {

inline bool is_parallel_outside(std::size_t count, const TaskArena& threads) {
    return int(count) >= threads.thread_count();
}

/// Calls work(n), which returns a Status, for all members. @returns the first error by number
template <class Work>
Status for_all(std::size_t count, const TaskArena& threads, const Work& work) {
    std::vector<std::optional<Error>> errors(count);
    const auto one = [&](std::size_t n) {
        const Status s = attempt([&]() -> Status { return work(n); });
        if (!s.ok()) errors[n] = s.error();
    };
    if (!is_parallel_outside(count, threads)) {
        for (std::size_t n = 0; n < count; ++n) one(n);
    } else {
        threads.for_each(std::int64_t(count), 1, [&](std::int64_t begin, std::int64_t end) {
            for (auto n = begin; n < end; ++n) one(std::size_t(n));
        });
    }
    for (const auto& error : errors)
        if (error) return *error;
    return Ok{};
}

}  // namespace pliant::gym
