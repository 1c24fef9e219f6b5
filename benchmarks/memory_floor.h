// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Memory floor: time of plain loops over arrays of the same size that read and write, or only read,
// as many bytes as a step of the subject must.

#pragma once

#include <benchmark/benchmark.h>
#include <pliant/core/tasks.h>

#include <cstdint>
#include <vector>

namespace pliant::bench {

class MemoryFloor {
  public:
    /// In bytes.
    MemoryFloor(std::int64_t read_written, std::int64_t read, const TaskArena& arena)
        : m_changed(std::size_t(read_written / 4), 1),
          m_read(std::size_t(read / 4), 1),
          m_arena(arena) {}

    void run() {
        constexpr std::int64_t kGrain = 1 << 16;
        m_arena.for_each(std::int64_t(m_changed.size()), kGrain, [&](auto begin, auto end) {
            for (auto n = begin; n < end; ++n) m_changed[std::size_t(n)] += 3;
        });
        m_arena.for_each(std::int64_t(m_read.size()), kGrain, [&](auto begin, auto end) {
            std::uint32_t sum = 0;
            for (auto n = begin; n < end; ++n) sum += m_read[std::size_t(n)];
            benchmark::DoNotOptimize(sum);
        });
    }

  private:
    std::vector<std::uint32_t> m_changed, m_read;
    const TaskArena& m_arena;
};

}  // namespace pliant::bench
