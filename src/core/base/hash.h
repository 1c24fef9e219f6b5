// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Ordered 64-bit hash of golden results, the same on all machines; mixes as [Appleby2011] does.

#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace pliant {

class Hash64 {
  public:
    void add_word(std::uint64_t word) {
        std::uint64_t h = m_state ^ (word * 0x9e3779b97f4a7c15ULL);
        h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdULL;
        m_state = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53ULL + 0x2545f4914f6cdd1dULL;
    }
    /// @tparam T  a number, or consists of numbers as large as its alignment
    template <class T>
    void add(std::span<const T> values) {
        add_part(values);
        add_word(values.size_bytes());
    }
    /// Adds a part of a span. Parts of whole words, with the total count after the last one, are
    /// equivalent to one call of add.
    template <class T>
    void add_part(std::span<const T> values) {
        const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
        std::size_t left = values.size_bytes();
        for (; left >= 8; left -= 8, bytes += 8) add_partial<alignof(T)>(bytes, 8);
        if (left) add_partial<alignof(T)>(bytes, left);
    }
    std::uint64_t value() const { return m_state; }

  private:
    /// @tparam Size  bytes of a number
    template <std::size_t Size>
    void add_partial(const unsigned char* bytes, std::size_t count) {
        std::uint64_t word = 0;
        std::memcpy(&word, bytes, count);
        // The first number is the lowest one on every machine.
        if constexpr (std::endian::native == std::endian::big && Size < 8) {
            std::uint64_t numbers = 0;
            for (std::size_t n = 0; n < 8; n += Size, word >>= 8 * Size)
                numbers = numbers << 8 * Size | (word & ((std::uint64_t(1) << 8 * Size) - 1));
            word = numbers;
        }
        add_word(word);
    }
    std::uint64_t m_state = 0x51ed270b2a8d5f1bULL;
};

}  // namespace pliant
