// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Air elements of a brick of 8³, and its skin (air.h), one bit per element. A slice is one word of
// 64 bits, so a few shifts and ands process all of its elements at once.
//
//     slice z, bit x + 8·y            the slice moved by −k along x: the bit of x + k comes to x,
//         y=1  o o o o o o o o        and the incoming bits are from the four columns beside it
//        y=0  o o o o o o o o
//     bit     0 1 2 3 4 5 6 7         along y by 8·k bits, along z by k words

#pragma once

#include <array>
#include <cstdint>

#include "material/air.h"

namespace pliant {

class AirBits {
  public:
    static constexpr int kSize = 8;

    /// Bits of the eight elements of a row, the lowest for the lowest x. @pre y in 0…7, z in −4…11
    void set_row(int y, int z, unsigned bits) {
        m_slices[std::size_t(z + kSkinReach)] |= std::uint64_t(bits) << (kSize * y);
    }
    bool any() const {
        std::uint64_t any = 0;
        for (int z = 0; z < kSize; ++z) any |= slice(z);
        return any != 0;
    }
    /// Sets the elements beside a row: −4…−1 in the lowest bits of `low`, 8…11 in those of `high`.
    void set_beside_row(int y, int z, unsigned low, unsigned high) {
        m_low_x[std::size_t(z)] |= std::uint64_t(low) << (kSize * y + kSize - kSkinReach);
        m_high_x[std::size_t(z)] |= std::uint64_t(high) << (kSize * y);
    }
    /// Sets a row beside a slice. @pre y in −4…−1 or 8…11, z in 0…7
    void set_row_beside(int y, int z, unsigned bits) {
        if (y < 0)
            m_low_y[std::size_t(z)] |= std::uint64_t(bits) << (kSize * (y + kSize));
        else
            m_high_y[std::size_t(z)] |= std::uint64_t(bits) << (kSize * (y - kSize));
    }

    std::uint64_t slice(int z) const { return m_slices[std::size_t(z + kSkinReach)]; }
    /// Air elements of the slice that are skin, along each axis.
    std::array<std::uint64_t, 3> skin(int z) const {
        return {skin_along(z, [&](int k) { return moved_x(z, k); }),
                skin_along(z, [&](int k) { return moved_y(z, k); }),
                skin_along(z, [&](int k) { return slice(z + k); })};
    }

  private:
    static constexpr std::uint64_t kRows = 0x0101010101010101;

    /// The slice, moved so that x + k comes to x; k in −4…4.
    std::uint64_t moved_x(int z, int k) const {
        const std::uint64_t here = slice(z);
        if (k > 0) {
            const std::uint64_t from_here = kRows * (0xFFu >> k);
            return (here >> k & from_here) | (m_high_x[std::size_t(z)] << (kSize - k) & ~from_here);
        }
        const std::uint64_t from_here = kRows * (0xFFu << -k & 0xFFu);
        return (here << -k & from_here) | (m_low_x[std::size_t(z)] >> (kSize + k) & ~from_here);
    }
    std::uint64_t moved_y(int z, int k) const {
        const std::uint64_t here = slice(z);
        if (k > 0) return here >> kSize * k | m_high_y[std::size_t(z)] << (64 - kSize * k);
        return here << kSize * -k | m_low_y[std::size_t(z)] >> (64 - kSize * -k);
    }
    /// skin_axes of air.h, for one axis and a whole slice.
    template <class Moved>
    std::uint64_t skin_along(int z, const Moved& moved) const {
        // [n]: elements with only air for the next n steps down and up.
        std::array<std::uint64_t, kSkinReach + 1> low, high;
        low[0] = high[0] = ~std::uint64_t(0);
        for (int n = 1; n <= kSkinReach; ++n) {
            const auto k = std::size_t(n);
            low[k] = low[k - 1] & moved(-n);
            high[k] = high[k - 1] & moved(n);
        }
        std::uint64_t skin = 0;
        for (std::size_t near = 1; near <= kSkinDepth; ++near)
            skin |= (low[near - 1] & ~low[near] & high[near + 1]) |
                    (high[near - 1] & ~high[near] & low[near + 1]);
        return skin & slice(z);
    }

    /// Slices, from kSkinReach below the brick to kSkinReach above.
    std::array<std::uint64_t, kSize + 2 * kSkinReach> m_slices{};
    /// [slice]: elements beside it, in the bits to which a move takes them.
    std::array<std::uint64_t, kSize> m_low_x{}, m_high_x{}, m_low_y{}, m_high_y{};
};

}  // namespace pliant
