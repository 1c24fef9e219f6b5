// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "field/brick_index.h"

#include <algorithm>
#include <new>
#include <utility>

#include "volume/boxes.h"

namespace pliant {

BrickIndex::BrickIndex(Vec3i size) : m_size(size) {
    const std::size_t count = std::max<std::size_t>(1, dense_count(size));
    m_inside.reset(static_cast<int*>(std::calloc(count, sizeof(int))));
    if (!m_inside) throw std::bad_alloc();
}

std::size_t BrickIndex::home_of(Vec3i coord) const {
    const std::uint64_t mixed = std::uint64_t(std::uint32_t(coord.x)) * 0x9E3779B97F4A7C15u ^
                                std::uint64_t(std::uint32_t(coord.y)) * 0xC2B2AE3D27D4EB4Fu ^
                                std::uint64_t(std::uint32_t(coord.z)) * 0x165667B19E3779F9u;
    return std::size_t(mixed ^ mixed >> 32) & (m_slots.size() - 1);
}

int BrickIndex::find_outside(Vec3i coord) const {
    if (m_slots.empty()) return -1;
    for (std::size_t n = home_of(coord);; n = (n + 1) & (m_slots.size() - 1)) {
        if (m_slots[n].brick_plus_one == 0) return -1;
        if (m_slots[n].coord == coord) return m_slots[n].brick_plus_one - 1;
    }
}

std::array<int, 6> BrickIndex::find_neighbours(Vec3i coord) const {
    const auto next = [&](int side) {
        Vec3i there = coord;
        there[side / 2] += side % 2 ? 1 : -1;
        return there;
    };
    std::array<int, 6> found;
    // All are inside if two opposite corners are.
    if (!is_inside(coord - Vec3i{1, 1, 1}) || !is_inside(coord + Vec3i{1, 1, 1})) {
        for (int side = 0; side < 6; ++side) found[std::size_t(side)] = find(next(side));
        return found;
    }
    const int* at = m_inside.get() + index_of(coord);
    const auto row = std::ptrdiff_t(m_size.x), slice = row * m_size.y;
    found = {at[-1] - 1, at[1] - 1, at[-row] - 1, at[row] - 1, at[-slice] - 1, at[slice] - 1};
    return found;
}

void BrickIndex::insert(Vec3i coord, int brick) {
    if (is_inside(coord)) {
        m_inside.get()[index_of(coord)] = brick + 1;
        return;
    }
    reserve_outside(m_outside_count + 1);
    std::size_t n = home_of(coord);
    while (m_slots[n].brick_plus_one != 0) n = (n + 1) & (m_slots.size() - 1);
    m_slots[n] = {coord, brick + 1};
    ++m_outside_count;
}

void BrickIndex::erase(Vec3i coord) {
    if (is_inside(coord)) {
        m_inside.get()[index_of(coord)] = 0;
        return;
    }
    const std::size_t mask = m_slots.size() - 1;
    std::size_t hole = home_of(coord);
    while (m_slots[hole].coord != coord || m_slots[hole].brick_plus_one == 0)
        hole = (hole + 1) & mask;
    // Entries after the hole move up if their search would otherwise end at it.
    for (std::size_t n = (hole + 1) & mask; m_slots[n].brick_plus_one != 0; n = (n + 1) & mask) {
        const std::size_t home = home_of(m_slots[n].coord);
        if (((n - home) & mask) < ((n - hole) & mask)) continue;
        m_slots[hole] = m_slots[n];
        hole = n;
    }
    m_slots[hole].brick_plus_one = 0;
    --m_outside_count;
}

void BrickIndex::grow() {
    std::vector<Slot> old(std::max<std::size_t>(64, 2 * m_slots.size()), Slot{{0, 0, 0}, 0});
    std::swap(old, m_slots);
    for (const Slot& slot : old) {
        if (slot.brick_plus_one == 0) continue;
        std::size_t n = home_of(slot.coord);
        while (m_slots[n].brick_plus_one != 0) n = (n + 1) & (m_slots.size() - 1);
        m_slots[n] = slot;
    }
}

}  // namespace pliant
