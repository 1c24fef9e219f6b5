// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/triangle_grid.h"

#include <algorithm>
#include <cmath>

namespace pliant::pbd {
namespace {

struct Box {
    Vec3d low, high;
    void add(Vec3d p) {
        for (int c = 0; c < 3; ++c) {
            low[c] = std::min(low[c], p[c]);
            high[c] = std::max(high[c], p[c]);
        }
    }
};

Box box_of(std::span<const Vec3d> positions, const std::array<std::int32_t, 3>& t, double margin) {
    const Vec3d first = positions[std::size_t(t[0])], m{margin, margin, margin};
    Box box{first, first};
    box.add(positions[std::size_t(t[1])]);
    box.add(positions[std::size_t(t[2])]);
    return {box.low - m, box.high + m};
}

/// A finer grid costs more to clear than it saves.
constexpr double kMaxCubesPerTriangle = 64;

}  // namespace

TriangleGrid::Range TriangleGrid::cubes_of(Vec3d low, Vec3d high) const {
    Range range{};
    for (int c = 0; c < 3; ++c) {
        const double most = double(m_size[c] - 1);
        const auto cube = [&](double x) {
            return int(std::clamp(std::floor((x - m_origin[c]) / m_cube), 0.0, most));
        };
        range.low[c] = cube(low[c]);
        range.high[c] = cube(high[c]);
    }
    return range;
}

void TriangleGrid::fill(std::span<const Vec3d> positions,
                        std::span<const std::array<std::int32_t, 3>> triangles, double margin) {
    Box all = box_of(positions, triangles[0], margin);
    double extent = 0;
    for (const auto& t : triangles) {
        const Box box = box_of(positions, t, margin);
        all.add(box.low);
        all.add(box.high);
        const Vec3d size = box.high - box.low;
        extent += std::max({size.x, size.y, size.z}) / double(triangles.size());
    }
    m_origin = all.low;
    const Vec3d size = all.high - all.low;
    const double most = kMaxCubesPerTriangle * double(triangles.size()) + 64;
    m_cube = extent;
    const auto count = [&](int c) { return std::floor(size[c] / m_cube) + 1; };
    while (count(0) * count(1) * count(2) > most) m_cube *= 1.25;
    m_size = {int(count(0)), int(count(1)), int(count(2))};

    // Counting sort: the triangles of a cube are ascending.
    m_starts.assign(index_of(0, 0, m_size.z) + 1, 0);
    const auto for_each_cube = [&](const Range& r, auto&& body) {
        for (int k = r.low.z; k <= r.high.z; ++k)
            for (int j = r.low.y; j <= r.high.y; ++j)
                for (int i = r.low.x; i <= r.high.x; ++i) body(index_of(i, j, k));
    };
    const auto range_of = [&](const std::array<std::int32_t, 3>& t) {
        const Box box = box_of(positions, t, margin);
        return cubes_of(box.low, box.high);
    };
    for (const auto& t : triangles)
        for_each_cube(range_of(t), [&](std::size_t cube) { ++m_starts[cube]; });
    std::int32_t sum = 0;
    for (std::int32_t& start : m_starts) start = sum += start;
    // Reserve for a moving wall, which fills more cubes later.
    if (std::size_t(sum) > m_entries.capacity()) m_entries.reserve(std::size_t(sum) * 2);
    m_entries.resize(std::size_t(sum));
    m_lows.resize(triangles.size());
    for (std::size_t t = triangles.size(); t-- > 0;) {
        const Range r = range_of(triangles[t]);
        m_lows[t] = r.low;
        for_each_cube(r, [&](std::size_t cube) {
            m_entries[std::size_t(--m_starts[cube])] = std::int32_t(t);
        });
    }
}

void TriangleGrid::near(Vec3d low, Vec3d high, std::vector<std::int32_t>& found) const {
    found.clear();
    const Range r = cubes_of(low, high);
    // A triangle is reported in the first cube that it shares with the box.
    const auto is_first = [](int cube, int of_triangle, int of_box) {
        return cube == std::max(of_triangle, of_box);
    };
    for (int k = r.low.z; k <= r.high.z; ++k)
        for (int j = r.low.y; j <= r.high.y; ++j)
            for (int i = r.low.x; i <= r.high.x; ++i) {
                const std::size_t cube = index_of(i, j, k);
                for (auto e = std::size_t(m_starts[cube]); e < std::size_t(m_starts[cube + 1]);
                     ++e) {
                    const Vec3i first = m_lows[std::size_t(m_entries[e])];
                    if (is_first(i, first.x, r.low.x) && is_first(j, first.y, r.low.y) &&
                        is_first(k, first.z, r.low.z))
                        found.push_back(m_entries[e]);
                }
            }
    std::sort(found.begin(), found.end());
}

}  // namespace pliant::pbd
