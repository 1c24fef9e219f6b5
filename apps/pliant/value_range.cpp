// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Percentiles by counting (radix selection). Values are mapped to whole numbers in the same order.
// The upper 16 bits are counted first, then the lower 16 bits for each upper half that contains a
// wanted rank. Each pass streams over the scan once.

#include "value_range.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

namespace pliant::app {
namespace {

constexpr std::size_t kHalves = 1 << 16;
constexpr std::size_t kRankCount = kPercentCount + 2;  // minimum, percentiles, maximum

/// Order-preserving integer of a value; 16-bit values have zero lower halves.
std::uint32_t key_of(std::int16_t value) {
    return std::uint32_t(value + 32768) << 16;
}
std::uint32_t key_of(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}
double value_of(std::uint32_t key, std::int16_t) {
    return double(int(key >> 16) - 32768);
}
double value_of(std::uint32_t key, float) {
    return double(std::bit_cast<float>(key & 0x80000000u ? key & 0x7fffffffu : ~key));
}

struct Place {
    std::size_t half = 0;    ///< half that contains the rank's value
    std::uint64_t rank = 0;  ///< rank within that half
};

Place find_rank(const std::vector<std::uint64_t>& counts, std::uint64_t rank) {
    std::size_t half = 0;
    for (; rank >= counts[half]; ++half) rank -= counts[half];
    return {half, rank};
}

/// Histogram of the upper halves.
template <class T>
std::vector<std::uint64_t> count_upper(const VoxelArray<T>& voxels) {
    // Two alternating tables, because equal neighbours would cause store-to-load stalls on one.
    std::array<std::vector<std::uint64_t>, 2> counts;
    for (auto& table : counts) table.resize(kHalves);
    voxels.for_each_piece([&](std::span<const T> piece) {
        std::size_t n = 0;
        for (; n + 1 < piece.size(); n += 2) {
            ++counts[0][key_of(piece[n]) >> 16];
            ++counts[1][key_of(piece[n + 1]) >> 16];
        }
        if (n < piece.size()) ++counts[0][key_of(piece[n]) >> 16];
    });
    for (std::size_t half = 0; half < kHalves; ++half) counts[0][half] += counts[1][half];
    return std::move(counts[0]);
}

template <class T>
std::array<double, kRankCount> values_of_ranks(const VoxelArray<T>& voxels,
                                               const std::array<std::uint64_t, kRankCount>& ranks) {
    const auto upper = count_upper(voxels);
    std::array<Place, kRankCount> positions;
    std::map<std::size_t, std::vector<std::uint64_t>> lower;
    for (std::size_t r = 0; r < kRankCount; ++r) {
        positions[r] = find_rank(upper, ranks[r]);
        lower[positions[r].half];
    }
    if constexpr (sizeof(T) > 2) {
        std::vector<std::uint64_t*> tables(kHalves);
        for (auto& [half, counts] : lower) {
            counts.resize(kHalves);
            tables[half] = counts.data();
        }
        voxels.for_each_piece([&](std::span<const T> piece) {
            for (const T value : piece) {
                const std::uint32_t key = key_of(value);
                if (std::uint64_t* table = tables[key >> 16]) ++table[key & 0xffff];
            }
        });
    }
    std::array<double, kRankCount> values{};
    for (std::size_t r = 0; r < kRankCount; ++r) {
        auto key = std::uint32_t(positions[r].half << 16);
        if constexpr (sizeof(T) > 2)
            key |= std::uint32_t(find_rank(lower[positions[r].half], positions[r].rank).half);
        values[r] = value_of(key, T{});
    }
    return values;
}

}  // namespace

ValueRange value_range(const Volume& volume) {
    const std::size_t count = voxel_count(volume.grid);
    std::array<std::uint64_t, kRankCount> ranks{};
    for (std::size_t p = 0; p < kPercentCount; ++p)
        ranks[p + 1] = std::uint64_t(std::llround(kPercents[p] / 100 * double(count - 1)));
    ranks.back() = count - 1;
    const auto values = std::visit(
        [&](const auto& voxels) { return values_of_ranks(voxels, ranks); }, volume.voxels);
    ValueRange range;
    range.min = values.front();
    range.max = values.back();
    for (std::size_t p = 0; p < kPercentCount; ++p) range.percentiles[p] = values[p + 1];
    return range;
}

}  // namespace pliant::app
