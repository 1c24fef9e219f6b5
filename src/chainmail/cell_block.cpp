// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/cell_block.h"

#include <algorithm>
#include <tuple>

namespace pliant {

void CellBlock::load(const Lattice& lattice, Vec3i coord) {
    m_size = lattice.brick_size();
    m_row = m_size + 1;
    m_first = m_size * coord;
    const auto n = std::size_t(m_row) * std::size_t(m_row) * std::size_t(m_row);
    for (auto& component : m_u) component.assign(n, 0);
    m_moved.assign(n, 0);
    m_lowest = m_highest = {0, 0, 0};
    for (int c = 0; c < 8; ++c) {
        const Vec3i offset{c & 1, c >> 1 & 1, c >> 2};
        const int found = lattice.find_brick(coord + offset);
        if (found >= 0) copy_from_brick(lattice, lattice.brick(found), offset);
    }
}

void CellBlock::copy_from_brick(const Lattice& lattice, const Brick& brick, Vec3i offset) {
    // Of a neighbour on a high side only its first layer belongs to the block.
    const auto count = [&](int axis) { return offset[axis] ? 1 : m_size; };
    for (int z = 0; z < count(2); ++z)
        for (int y = 0; y < count(1); ++y)
            for (int x = 0; x < count(0); ++x) {
                const auto from = std::size_t(x + lattice.stride(1) * y + lattice.stride(2) * z);
                const auto to = std::size_t(
                    index(x + m_size * offset.x, y + m_size * offset.y, z + m_size * offset.z));
                for (int a = 0; a < 3; ++a) {
                    const Fixed u = brick.u[std::size_t(a)][from];
                    m_u[std::size_t(a)][to] = u;
                    m_moved[to] |= u != 0;
                    m_lowest[a] = std::min(m_lowest[a], u);
                    m_highest[a] = std::max(m_highest[a], u);
                }
            }
}

std::array<int, 8> CellBlock::corners(int x, int y, int z) const {
    std::array<int, 8> result{};
    for (int c = 0; c < 8; ++c)
        result[std::size_t(c)] = index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
    return result;
}

std::vector<Vec3i> cell_blocks(const Lattice& lattice) {
    std::vector<Vec3i> coords;
    for (const int brick : lattice.resident_bricks())
        for (int c = 0; c < 8; ++c)
            coords.push_back(lattice.brick(brick).coord - Vec3i{c & 1, c >> 1 & 1, c >> 2});
    std::sort(coords.begin(), coords.end(),
              [](Vec3i p, Vec3i q) { return std::tie(p.z, p.y, p.x) < std::tie(q.z, q.y, q.x); });
    coords.erase(std::unique(coords.begin(), coords.end()), coords.end());
    return coords;
}

void bound_block(const Lattice& lattice, Vec3i coord, Vec3<Fixed>& lowest, Vec3<Fixed>& highest) {
    lowest = highest = {0, 0, 0};
    for (int c = 0; c < 8; ++c) {
        const int found = lattice.find_brick(coord + Vec3i{c & 1, c >> 1 & 1, c >> 2});
        if (found < 0) continue;
        const Brick& brick = lattice.brick(found);
        for (int a = 0; a < 3; ++a) {
            lowest[a] = std::min(lowest[a], brick.u_min[a]);
            highest[a] = std::max(highest[a], brick.u_max[a]);
        }
    }
}

std::array<Vec3d, 8> deformed_corners(const CellBlock& block, const std::array<int, 8>& corners,
                                      Vec3d scale) {
    std::array<Vec3d, 8> points{};
    for (int c = 0; c < 8; ++c) {
        const Vec3<Fixed> u = block.displacement(corners[std::size_t(c)]);
        points[std::size_t(c)] = {(c & 1) + scale.x * u.x, (c >> 1 & 1) + scale.y * u.y,
                                  (c >> 2) + scale.z * u.z};
    }
    return points;
}

}  // namespace pliant
