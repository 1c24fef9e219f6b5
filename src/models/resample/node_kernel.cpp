// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/node_kernel.h"

#include <algorithm>
#include <array>

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "resample/node_kernel.cpp"  // this file, compiled again for each target
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// @param from  size elements
HWY_INLINE void convert_row(const Fixed* HWY_RESTRICT from, int size, Fixed base, float scale,
                            float shift, float* HWY_RESTRICT to) {
    const hn::CappedTag<float, 8> d;
    const hn::RebindToSigned<decltype(d)> di;
    constexpr auto kLanes = int(hn::MaxLanes(d));
    int x = 0;
    for (; x + kLanes <= size; x += kLanes) {
        const auto u = hn::ConvertTo(d, hn::Sub(hn::LoadU(di, from + x), hn::Set(di, base)));
        hn::StoreU(hn::Add(hn::Mul(u, hn::Set(d, scale)), hn::Set(d, shift)), d, to + x);
    }
    for (; x < size; ++x) to[x] = float(from[x] - base) * scale + shift;
}

/// @param kSize  size of bricks as a compile-time constant; else 0
template <int kSize>
HWY_INLINE void convert_rows(std::span<const Fixed* const> from, std::span<const NodeRow> rows,
                             int any_size, Fixed base, float scale, float shift, float* to) {
    const int size = kSize ? kSize : any_size;
    const std::size_t along_x =
        kSize ? std::size_t(StripLayout(kSize).bricks) + 1 : from.size() / 4;
    const std::size_t last = along_x - 1;
    const int row_size = int(last) * size + 1;
    for (const NodeRow row : rows) {
        const bool hy = row.y == size, hz = row.z == size;
        const Fixed* const* bricks = &from[along_x * (std::size_t(hy) + 2 * std::size_t(hz))];
        const int at = size * ((hy ? 0 : row.y) + size * (hz ? 0 : row.z));
        float* HWY_RESTRICT row_to = to + row_size * (row.y + (size + 1) * row.z);
        for (std::size_t b = 0; b < last; ++b, row_to += size)
            convert_row(bricks[b] + at, size, base, scale, shift, row_to);
        *row_to = float(bricks[last][at] - base) * scale + shift;
    }
}

void convert_bricks(std::span<const Fixed* const> from, std::span<const NodeRow> rows, int size,
                    Fixed base, float scale, float shift, float* to) {
    if (size == 8)  // the usual case
        convert_rows<8>(from, rows, size, base, scale, shift, to);
    else
        convert_rows<0>(from, rows, size, base, scale, shift, to);
}

/// Bit i: element i is not zero. @param count  number of elements, at most 64
HWY_INLINE BitWord moved_in_word(const Fixed* HWY_RESTRICT u, int count) {
    const hn::CappedTag<Fixed, 16> d;
    constexpr auto kLanes = int(hn::MaxLanes(d));
    BitWord bits = 0;
    int i = 0;
    for (; i + kLanes <= count; i += kLanes) {
        std::uint8_t mask[8] = {};
        hn::StoreMaskBits(d, hn::Ne(hn::LoadU(d, u + i), hn::Zero(d)), mask);
        bits |= BitWord(mask[0] | unsigned(mask[1]) << 8) << i;
    }
    for (; i < count; ++i) bits |= BitWord(u[i] != 0) << i;
    return bits;
}

void find_moved_bits(const std::array<const Fixed*, 3>& u, int words, int count,
                     BitWord* HWY_RESTRICT bits) {
    const BitWord all = low_bits(count);
    for (int w = 0, at = 0; w < words; ++w, at += count) {
        bits[w] = 0;
        for (const Fixed* axis : u)
            if (axis && bits[w] != all) bits[w] |= moved_in_word(axis + at, count);
    }
}

void convert_16_bits(const std::int16_t* from, Vec3i scan, std::span<const NodeRow> rows,
                     int row_size, int row_count, float* to) {
    const hn::CappedTag<float, 8> d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<std::int16_t, decltype(d)> d16;
    constexpr auto kLanes = int(hn::MaxLanes(d));
    for (const NodeRow row : rows) {
        const std::int16_t* HWY_RESTRICT row_from =
            from + scan.x * (row.y + std::ptrdiff_t(scan.y) * row.z);
        float* HWY_RESTRICT row_to = to + row_size * (row.y + row_count * row.z);
        int x = 0;
        for (; x + kLanes <= row_size; x += kLanes)
            hn::StoreU(hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d16, row_from + x))), d,
                       row_to + x);
        for (; x < row_size; ++x) row_to[x] = row_from[x];
    }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace pliant
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
namespace {
HWY_EXPORT(convert_bricks);
HWY_EXPORT(convert_16_bits);
HWY_EXPORT(find_moved_bits);
}  // namespace

void convert_displacements(std::span<const Fixed* const> from, std::span<const NodeRow> rows,
                           int brick_size, Fixed base, float scale, float shift, float* to) {
    HWY_DYNAMIC_DISPATCH(convert_bricks)(from, rows, brick_size, base, scale, shift, to);
}

void find_moved(const std::array<const Fixed*, 3>& u, int words, int elements_per_word,
                BitWord* bits) {
    HWY_DYNAMIC_DISPATCH(find_moved_bits)(u, words, elements_per_word, bits);
}

void convert_values(const std::int16_t* from, Vec3i scan_size, std::span<const NodeRow> rows,
                    int row_size, int row_count, float* to) {
    HWY_DYNAMIC_DISPATCH(convert_16_bits)(from, scan_size, rows, row_size, row_count, to);
}
void convert_values(const float* from, Vec3i scan_size, std::span<const NodeRow> rows, int row_size,
                    int row_count, float* to) {
    for (const NodeRow row : rows)
        std::copy_n(from + scan_size.x * (row.y + std::ptrdiff_t(scan_size.y) * row.z), row_size,
                    to + row_size * (row.y + row_count * row.z));
}

}  // namespace pliant
#endif
