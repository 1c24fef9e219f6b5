// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One bit for each element of a brick, or for each of its cells or voxels.
//
// Bits are in the order of the elements. A word holds a layer if it has enough bits, else a row: so
// the neighbours along any axis are a shift or another word.

#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

namespace pliant {

using BitWord = std::uint64_t;
/// One bit per element of a row along x.
using RowBits = std::uint64_t;

inline constexpr int kLargestBrick = 32, kUsualBrick = 8;
/// Memory for the bits of any brick.
using AnyBrickBits = std::array<BitWord, kLargestBrick * kLargestBrick>;

/// @param count  0…64
constexpr BitWord low_bits(int count) {
    return count < 64 ? (BitWord(1) << count) - 1 : ~BitWord(0);
}

/// std::popcount is a function call unless the target is known to have the instruction.
constexpr int count_of(BitWord bits) {
    bits -= bits >> 1 & 0x5555555555555555u;
    bits = (bits & 0x3333333333333333u) + (bits >> 2 & 0x3333333333333333u);
    return int(((bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0fu) * 0x0101010101010101u >> 56);
}

/// Layout of the bits. @tparam Size  int, or a constant
template <class Size>
struct BitLayout {
    Size size;  ///< elements along a brick's edge

    constexpr bool has_layers() const { return size * size <= 64; }
    constexpr int words_per_layer() const { return has_layers() ? 1 : int(size); }
    constexpr int words() const { return words_per_layer() * size; }
    constexpr int elements_per_word() const { return has_layers() ? size * size : int(size); }
    /// A word with all of its bits set.
    constexpr BitWord all() const { return low_bits(elements_per_word()); }
    constexpr RowBits row(const BitWord* bits, int y, int z) const {
        return has_layers() ? bits[z] >> y * size & low_bits(size) : bits[y + size * z];
    }
};

/// Calls work(layout of a brick of that size), with the usual size as a compile-time constant.
template <class Work>
auto with_bit_layout(int size, const Work& work) {
    using Usual = std::integral_constant<int, kUsualBrick>;
    return size == kUsualBrick ? work(BitLayout<Usual>{}) : work(BitLayout<int>{size});
}

/// Combines each bit with its seven neighbours on the high or on the low side along each axis.
/// @param from  the brick's bits, and those of the bricks on that side: c & 1 is the step along x
///              of brick c, c >> 1 & 1 along y, c >> 2 along z. @param combine  of two words
template <bool kHighSide, class Size, class Combine>
void combine_around(const BitLayout<Size>& layout, const std::array<const BitWord*, 8>& from,
                    const Combine& combine, BitWord* to) {
    const int size = layout.size, n = layout.words_per_layer(), row = size * (size - 1);
    const BitWord all = layout.all(), first = all / low_bits(size), last = first << (size - 1);
    const auto along_x = [&](BitWord own, BitWord beside) {
        return combine(own, kHighSide ? (own >> 1 & ~last) | (beside & first) << (size - 1)
                                      : (own << 1 & ~first & all) | (beside >> (size - 1) & first));
    };
    const auto layer_of = [&](int z, std::size_t brick, BitWord* layer) {
        const auto word = [&](std::size_t c, int w) { return from[brick + c][w + n * z]; };
        const int edge = kHighSide ? 0 : n - 1;
        const BitWord beside = along_x(word(2, edge), word(3, edge));
        if (layout.has_layers()) {
            const BitWord own = along_x(word(0, 0), word(1, 0));
            const BitWord next =
                kHighSide ? own >> size | beside << row : own << size | beside >> row;
            *layer = combine(own, next) & all;
            return;
        }
        std::array<BitWord, kLargestBrick> rows;
        for (int w = 0; w < n; ++w) rows[std::size_t(w)] = along_x(word(0, w), word(1, w));
        for (int w = 0; w < n; ++w) {
            const int next = kHighSide ? w + 1 : w - 1;
            layer[w] = combine(rows[std::size_t(w)],
                               w == n - 1 - edge ? beside : rows[std::size_t(next)]) &
                       all;
        }
    };
    for (int z = 0; z < size; ++z) layer_of(z, 0, to + n * z);
    std::array<BitWord, kLargestBrick> beyond;
    layer_of(kHighSide ? 0 : size - 1, 4, beyond.data());
    for (int i = 0; i < size; ++i) {
        const int z = kHighSide ? i : size - 1 - i;
        const BitWord* next = i + 1 == size ? beyond.data() : to + n * (kHighSide ? z + 1 : z - 1);
        for (int w = 0; w < n; ++w) to[w + n * z] = combine(to[w + n * z], next[w]);
    }
}

}  // namespace pliant
