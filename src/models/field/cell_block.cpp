// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "field/cell_block.h"

#include <algorithm>
#include <tuple>

namespace pliant {

void CellBlock::load(const Field& field, Vec3i coord) {
    m_size = field.brick_size();
    m_row = m_size + 1;
    m_first = m_size * coord;
    const auto n = std::size_t(m_row) * std::size_t(m_row) * std::size_t(m_row);
    for (auto& component : m_u) component.assign(n, 0);
    for (int c = 0; c < 8; ++c) {
        const Vec3i offset{c & 1, c >> 1 & 1, c >> 2};
        const int found = field.find_brick(coord + offset);
        if (found >= 0) copy_from_brick(field, field.brick(found), offset);
    }
    find_touched();
}

void CellBlock::copy_from_brick(const Field& field, const FieldBrick& brick, Vec3i offset) {
    // For a neighbour on a high side only its first layer belongs to the block.
    const auto count = [&](int axis) { return offset[axis] ? 1 : m_size; };
    for (int z = 0; z < count(2); ++z)
        for (int y = 0; y < count(1); ++y) {
            const int from = field.stride(1) * y + field.stride(2) * z;
            const int to = index(m_size * offset.x, y + m_size * offset.y, z + m_size * offset.z);
            for (std::size_t a = 0; a < 3; ++a)
                std::copy_n(brick.u[a] + from, count(0), m_u[a].data() + to);
        }
}

void CellBlock::find_touched() {
    const std::size_t n = m_u[0].size();
    m_moved.resize(n);
    for (std::size_t i = 0; i < n; ++i) m_moved[i] = (m_u[0][i] | m_u[1][i] | m_u[2][i]) != 0;
    // ORs the moved flags of a cell's eight corners, one axis at a time. Overflow into the next
    // row ends at elements that are no cell's lowest corner.
    m_touched = m_moved;
    const auto row = std::size_t(m_row);
    for (const std::size_t step : {std::size_t(1), row, row * row})
        for (std::size_t i = 0; i + step < n; ++i) m_touched[i] |= m_touched[i + step];
}

std::vector<Vec3i> cell_blocks(const Field& field) {
    std::vector<Vec3i> coords;
    for (const int brick : field.resident_bricks())
        for (int c = 0; c < 8; ++c)
            coords.push_back(field.brick(brick).coord - Vec3i{c & 1, c >> 1 & 1, c >> 2});
    std::sort(coords.begin(), coords.end(),
              [](Vec3i p, Vec3i q) { return std::tie(p.z, p.y, p.x) < std::tie(q.z, q.y, q.x); });
    coords.erase(std::unique(coords.begin(), coords.end()), coords.end());
    return coords;
}

void bound_block(const Field& field, Vec3i coord, Vec3<Fixed>& lowest, Vec3<Fixed>& highest) {
    lowest = highest = {0, 0, 0};
    for (int c = 0; c < 8; ++c) {
        const int found = field.find_brick(coord + Vec3i{c & 1, c >> 1 & 1, c >> 2});
        if (found < 0) continue;
        const FieldBrick& brick = field.brick(found);
        for (int a = 0; a < 3; ++a) {
            lowest[a] = std::min(lowest[a], brick.u_min[a]);
            highest[a] = std::max(highest[a], brick.u_max[a]);
        }
    }
}

}  // namespace pliant
