// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Software prefetch queue: cache lines that the next strip will touch, fetched in small portions
// during other work.
//
// Bricks lie anywhere in memory and rows of voxels far apart, so hardware prefetchers can't predict
// the lines that a strip of cells touches. Fetched all at once they would fill the processor's
// queue of misses, and the thread would stall.

#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pliant {

class Ahead {
  public:
    void clear() { m_next = m_end = 0; }
    /// Adds the lines of some bytes, up to the capacity.
    void want(const void* first, std::size_t bytes) {
        const auto begin = reinterpret_cast<std::uintptr_t>(first);
        want_lines(begin & ~(kLine - 1), begin + bytes);
    }
    /// Likewise, without the line that contains the first byte if it began before: it was added
    /// earlier.
    void want_on(const void* first, std::size_t bytes) {
        const auto begin = reinterpret_cast<std::uintptr_t>(first);
        want_lines((begin + kLine - 1) & ~(kLine - 1), begin + bytes);
    }
    /// Number of queued lines.
    std::size_t left() const { return m_end - m_next; }
    /// Prefetches some lines into the second-level cache: the present work fills the first.
    void fetch(std::size_t count) {
        const std::size_t begin = m_next, end = begin + std::min(count, left());
        for (std::size_t n = begin; n < end; ++n)
            __builtin_prefetch(reinterpret_cast<const void*>(m_lines[n]), 0, 2);
        m_next = end;
    }

  private:
    void want_lines(std::uintptr_t begin, std::uintptr_t end) {
        for (; begin < end && m_end < kMost; begin += kLine) m_lines[m_end++] = begin;
    }

    static constexpr std::uintptr_t kLine = 64;  ///< size of a cache line [bytes]
    static constexpr std::size_t kMost = 2048;

    std::array<std::uintptr_t, kMost> m_lines;
    std::size_t m_next = 0, m_end = 0;
};

}  // namespace pliant
