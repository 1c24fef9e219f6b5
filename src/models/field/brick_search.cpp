// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "field/brick_search.h"

#include <algorithm>
#include <cmath>

#include "field/cell_block.h"
#include "field/fixed_point.h"
#include "volume/boxes.h"

namespace pliant {

Position rest_position(const Grid& grid, Vec3i ijk) {
    const Vec3d h = grid.spacing_mm;
    return {std::llround(h.x * ijk.x * kUnitsPerMm), std::llround(h.y * ijk.y * kUnitsPerMm),
            std::llround(h.z * ijk.z * kUnitsPerMm)};
}

BrickSearch::BrickSearch(const Field& field) : m_field(field) {
    for (const int index : field.resident_bricks()) {
        const FieldBrick& brick = field.brick(index);
        for (int a = 0; a < 3; ++a) {
            m_lowest[a] = std::min(m_lowest[a], brick.u_min[a]);
            m_highest[a] = std::max(m_highest[a], brick.u_max[a]);
        }
    }
}

BrickSearch::Range BrickSearch::bricks_near(const PositionBox& box) const {
    const Grid& grid = m_field.grid();
    Vec3i low{}, high{};
    for (int a = 0; a < 3; ++a) {
        const double spacing = grid.spacing_mm[a] * kUnitsPerMm;
        // One extra element on each side, for links that start below, and for rounding.
        low[a] = int(std::floor(double(box.low[a] - m_highest[a]) / spacing)) - 1;
        high[a] = int(std::ceil(double(box.high[a] - m_lowest[a]) / spacing)) + 1;
        if (m_field.is_bounded()) {
            low[a] = std::max(low[a], 0);
            high[a] = std::min(high[a], grid.size[a] - 1);
        }
    }
    Range range{m_field.brick_of(low), m_field.brick_of(high) + Vec3i{1, 1, 1}};
    for (int a = 0; a < 3; ++a)
        if (high[a] < low[a]) range.end = range.begin;
    return range;
}

std::int64_t BrickSearch::brick_count(const PositionBox& box) const {
    const Range range = bricks_near(box);
    return std::int64_t(dense_count(range.end - range.begin));
}

void BrickSearch::for_each_brick(const PositionBox& box,
                                 const std::function<void(Vec3i, const PositionBox&)>& visit,
                                 const std::function<bool(const PositionBox&)>& may_meet) const {
    const Range range = bricks_near(box);
    const Vec3i layers{m_field.brick_size(), m_field.brick_size(), m_field.brick_size()};
    for (int z = range.begin.z; z < range.end.z; ++z)
        for (int y = range.begin.y; y < range.end.y; ++y)
            for (int x = range.begin.x; x < range.end.x; ++x) {
                const Vec3i first = m_field.brick_size() * Vec3i{x, y, z};
                const Position low = rest_position(m_field.grid(), first);
                const Position high = rest_position(m_field.grid(), first + layers);
                if (may_meet &&
                    !may_meet({moved_position(low, m_lowest), moved_position(high, m_highest)}))
                    continue;
                Vec3<Fixed> lowest, highest;
                bound_block(m_field, {x, y, z}, lowest, highest);
                const PositionBox own{moved_position(low, lowest), moved_position(high, highest)};
                bool meets = true;
                for (int a = 0; a < 3; ++a)
                    meets &= own.low[a] <= box.high[a] && own.high[a] >= box.low[a];
                if (meets) visit({x, y, z}, own);
            }
}

}  // namespace pliant
