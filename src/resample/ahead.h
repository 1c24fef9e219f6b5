// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What will be needed next, asked for little by little while something else is computed.
//
// Bricks lie anywhere in memory and rows of voxels far apart, so no processor foresees which lines
// of them a strip of cells touches. Asked for all at once they would queue, and whoever asks would
// wait with them.

#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pliant {

class Ahead {
  public:
    void clear() { m_next = m_end = 0; }
    /// Notes some bytes, as far as there is room.
    void want(const void* first, std::size_t bytes) {
        const auto begin = reinterpret_cast<std::uintptr_t>(first);
        want_lines(begin & ~(kLine - 1), begin + bytes);
    }
    /// Likewise, but for a line that began before: what lies there was wanted earlier.
    void want_on(const void* first, std::size_t bytes) {
        const auto begin = reinterpret_cast<std::uintptr_t>(first);
        want_lines((begin + kLine - 1) & ~(kLine - 1), begin + bytes);
    }
    /// Lines that are noted and not asked for yet.
    std::size_t left() const { return m_end - m_next; }
    /// Asks for some of them, into the second cache: the present work fills the first.
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

    static constexpr std::uintptr_t kLine = 64;  ///< of the cache [bytes]
    static constexpr std::size_t kMost = 2048;

    std::array<std::uintptr_t, kMost> m_lines;
    std::size_t m_next = 0, m_end = 0;
};

}  // namespace pliant
