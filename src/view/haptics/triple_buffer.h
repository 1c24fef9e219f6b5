// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Triple buffer: hands the newest value from one thread to another without waiting. One slot is
// written, one is read, and an atomic exchange passes on the third.

#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace pliant {

template <class T>
class TripleBuffer {
  public:
    /// Writes a value. One writer thread only.
    void write(const T& value) {
        m_positions[m_back] = value;
        m_back = m_middle.exchange(std::uint8_t(m_back | kFresh), std::memory_order_acq_rel) &
                 std::uint8_t(3);
    }
    /// Takes the newest value. One reader thread only. @returns null if no value came since the
    /// last call; otherwise valid until the next call
    const T* read() {
        if (!(m_middle.load(std::memory_order_relaxed) & kFresh)) return nullptr;
        m_front = m_middle.exchange(m_front, std::memory_order_acq_rel) & std::uint8_t(3);
        return &m_positions[m_front];
    }

  private:
    static constexpr std::uint8_t kFresh = 4;

    std::array<T, 3> m_positions{};
    std::uint8_t m_back = 0;  ///< the writer's slot
    std::atomic<std::uint8_t> m_middle{1};
    std::uint8_t m_front = 2;  ///< the reader's slot
    static_assert(std::atomic<std::uint8_t>::is_always_lock_free);
};

}  // namespace pliant
