// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Ring buffer from one writer to any number of readers; the writer never waits. Each slot has a
// sequence number that is odd during a write. A reader that is overtaken discards its copy. Words
// are atomic, stored with release and loaded with acquire: a reader of a newer word also sees the
// newer number.

#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>

namespace pliant {

template <class T, std::size_t kCount>
class RecordRing {
    static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 8 == 0);
    static_assert((kCount & (kCount - 1)) == 0, "a power of two");

  public:
    /// Appends a record. One writer thread only.
    void write(const T& record) {
        const std::uint64_t n = m_written.load(std::memory_order_relaxed);
        Slot& slot = (*m_slots)[n % kCount];
        std::uint64_t words[kWords];
        std::memcpy(words, &record, sizeof record);
        slot.number.store(2 * n + 1, std::memory_order_relaxed);
        for (std::size_t w = 0; w < kWords; ++w)
            slot.words[w].store(words[w], std::memory_order_release);
        slot.number.store(2 * n + 2, std::memory_order_release);
        m_written.store(n + 1, std::memory_order_release);
    }
    std::uint64_t written() const { return m_written.load(std::memory_order_acquire); }
    /// Reads record n, from 0. @returns false if it isn't written yet or already overwritten
    bool read(std::uint64_t n, T& record) const {
        const Slot& slot = (*m_slots)[n % kCount];
        if (slot.number.load(std::memory_order_acquire) != 2 * n + 2) return false;
        std::uint64_t words[kWords];
        for (std::size_t w = 0; w < kWords; ++w)
            words[w] = slot.words[w].load(std::memory_order_acquire);
        if (slot.number.load(std::memory_order_relaxed) != 2 * n + 2) return false;
        std::memcpy(&record, words, sizeof record);
        return true;
    }
    static constexpr std::size_t size() { return kCount; }

  private:
    static constexpr std::size_t kWords = sizeof(T) / 8;
    struct Slot {
        std::atomic<std::uint64_t> number{0};
        std::array<std::atomic<std::uint64_t>, kWords> words{};
    };

    std::unique_ptr<std::array<Slot, kCount>> m_slots =
        std::make_unique<std::array<Slot, kCount>>();
    std::atomic<std::uint64_t> m_written{0};
    static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
};

}  // namespace pliant
