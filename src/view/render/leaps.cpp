// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/leaps.h"

#include <cmath>
#include <limits>
#include <type_traits>

namespace pliant::render {
namespace {

/// Rows of distances with a border of kFarthest, so that each element has neighbours on all sides.
class Distances {
  public:
    explicit Distances(Vec3i size)
        : m_row(size.x + 2),
          m_slice(std::ptrdiff_t(m_row) * (size.y + 2)),
          m_values(std::size_t(m_slice) * std::size_t(size.z + 2), LeapMap::kFarthest) {}

    std::uint8_t* row(int y, int z) {
        return m_values.data() + 1 + (y + 1) * std::ptrdiff_t(m_row) + (z + 1) * m_slice;
    }

  private:
    int m_row;
    std::ptrdiff_t m_slice;
    std::vector<std::uint8_t> m_values;
};

/// One raster scan of the exact chessboard distance: a brick takes the minimum of its already
/// scanned neighbours, plus one. @param step  1: forwards; −1: backwards
void scan(Distances& distances, Vec3i size, int step) {
    std::vector<std::uint8_t> near(std::size_t(size.x) + 2);
    const auto first = [&](int n) { return step > 0 ? 0 : n - 1; };
    for (int k = 0, z = first(size.z); k < size.z; ++k, z += step)
        for (int j = 0, y = first(size.y); j < size.y; ++j, y += step) {
            const std::uint8_t* before[] = {
                distances.row(y - step, z), distances.row(y - 1, z - step),
                distances.row(y, z - step), distances.row(y + 1, z - step)};
            for (int x = -1; x <= size.x; ++x)
                near[std::size_t(x + 1)] = std::min(std::min(before[0][x], before[1][x]),
                                                    std::min(before[2][x], before[3][x]));
            std::uint8_t* row = distances.row(y, z);
            const std::uint8_t* n = near.data();
            for (int x = 0; x < size.x; ++x) {
                const int least = std::min(std::min(n[x], n[x + 1]), n[x + 2]) + 1;
                row[x] = std::uint8_t(std::min<int>(row[x], least));
            }
            for (int i = 0, x = first(size.x); i < size.x; ++i, x += step)
                row[x] = std::uint8_t(std::min<int>(row[x], row[x - step] + 1));
        }
}

}  // namespace

template <class T>
std::optional<T> threshold_of(double iso) {
    constexpr double kLeast = double(std::numeric_limits<T>::lowest());
    constexpr double kMost = double(std::numeric_limits<T>::max());
    if (!(iso > kLeast && iso <= kMost)) return std::nullopt;
    if constexpr (std::is_integral_v<T>) {
        return T(std::ceil(iso));
    } else {
        const T nearest = T(iso);
        return double(nearest) >= iso ? nearest : std::nextafter(nearest, T(kMost));
    }
}

template <class T>
LeapMap make_leap_map(const BrickLevel<T>& fine, T threshold) {
    LeapMap map;
    map.size = fine.size;
    map.codes.resize(fine.ranges.size() + 4);
    Distances distances(fine.size);
    const auto size_x = std::size_t(fine.size.x);
    const auto for_each_row = [&](const auto& body) {
        std::size_t n = 0;
        for (int z = 0; z < fine.size.z; ++z)
            for (int y = 0; y < fine.size.y; ++y, n += size_x)
                body(&fine.ranges[n], distances.row(y, z), &map.codes[n]);
    };
    for_each_row([&](const Range<T>* ranges, std::uint8_t* row, std::uint8_t*) {
        for (std::size_t x = 0; x < size_x; ++x)
            if (ranges[x].min < threshold && ranges[x].max >= threshold) row[x] = 0;
    });
    scan(distances, fine.size, 1);
    scan(distances, fine.size, -1);
    for_each_row([&](const Range<T>* ranges, const std::uint8_t* row, std::uint8_t* codes) {
        for (std::size_t x = 0; x < size_x; ++x)
            codes[x] = std::uint8_t(row[x] | (ranges[x].min >= threshold ? LeapMap::kAbove : 0));
    });
    return map;
}

template std::optional<std::int16_t> threshold_of(double);
template std::optional<float> threshold_of(double);
template LeapMap make_leap_map(const BrickLevel<std::int16_t>&, std::int16_t);
template LeapMap make_leap_map(const BrickLevel<float>&, float);

}  // namespace pliant::render
