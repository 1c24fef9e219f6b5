// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/touched.h"

#include <algorithm>
#include <array>
#include <functional>

namespace pliant {
namespace {

constexpr int kLargestBrick = 32;
constexpr std::int64_t kBricksPerTask = 64;

/// Rows of a brick and of the layers beside it on one side: side = size + 1 of them along y and z.
using HaloRows = std::array<RowBits, (kLargestBrick + 1) * (kLargestBrick + 1)>;

RowBits low_bits(int count) {
    return (RowBits(1) << count) - 1;
}

}  // namespace

void TouchedCells::find(const Snapshot& snapshot, int brick_size, const TaskArena& arena) {
    m_size = brick_size;
    list_bricks(snapshot);
    m_rows.resize(m_bricks.size() * std::size_t(m_size) * std::size_t(m_size));
    m_is_full.resize(m_bricks.size());
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n) {
            const auto place = std::size_t(n);
            m_is_full[place] = find_rows(snapshot, m_bricks[place],
                                         m_rows.data() + place * std::size_t(m_size * m_size));
        }
    };
    // By reference: a copy of the captures would be allocated.
    arena.for_each(std::int64_t(m_bricks.size()), kBricksPerTask, std::ref(task));
}

void TouchedCells::list_bricks(const Snapshot& snapshot) {
    m_bricks.clear();
    m_place_of.clear();
    m_box = {};
    if (snapshot.records().empty()) return;
    m_box = {snapshot.box().begin - Vec3i{1, 1, 1}, snapshot.box().end};
    const Vec3i n = m_box.end - m_box.begin;
    m_place_of.assign(std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z), -1);
    for (const BrickRecord& record : snapshot.records())
        for (int c = 0; c < 8; ++c)
            m_place_of[slot_of(record.coord - Vec3i{c & 1, c >> 1 & 1, c >> 2})] = 0;
    std::size_t slot = 0;
    for (int z = m_box.begin.z; z < m_box.end.z; ++z)
        for (int y = m_box.begin.y; y < m_box.end.y; ++y)
            for (int x = m_box.begin.x; x < m_box.end.x; ++x, ++slot) {
                if (m_place_of[slot] < 0) continue;
                m_place_of[slot] = std::int32_t(m_bricks.size());
                m_bricks.push_back({x, y, z});
            }
}

/// @returns whether all are touched
bool TouchedCells::find_rows(const Snapshot& snapshot, Vec3i brick, RowBits* rows) const {
    const int size = m_size, side = size + 1, all = size * size;
    // A moved element touches all eight cells around it.
    const BrickRecord* record = snapshot.record_at(brick);
    if (record && record->is_full) {
        std::fill_n(rows, all, low_bits(size));
        return true;
    }
    // Elements first: bit x of row (y, z), each 0…size.
    HaloRows halo;
    std::fill_n(halo.begin(), side * side, 0);
    for (int c = 0; c < 8; ++c) {
        const int hx = c & 1, hy = c >> 1 & 1, hz = c >> 2;
        const int found = snapshot.find(brick + Vec3i{hx, hy, hz});
        if (found < 0) continue;
        const RowBits* from = snapshot.altered_rows(found);
        for (int z = 0; z < (hz ? 1 : size); ++z) {
            RowBits* to = halo.data() + hy * size + side * (z + hz * size);
            for (int y = 0; y < (hy ? 1 : size); ++y)
                to[y] |= hx ? (from[y + size * z] & 1) << size : from[y + size * z];
        }
    }
    // Then cells, along one axis after the other.
    for (int r = 0; r < side * side; ++r) halo[std::size_t(r)] |= halo[std::size_t(r)] >> 1;
    for (int r = 0; r + 1 < side * side; ++r) halo[std::size_t(r)] |= halo[std::size_t(r + 1)];
    for (int r = 0; r < side * size; ++r) halo[std::size_t(r)] |= halo[std::size_t(r + side)];
    RowBits everywhere = low_bits(size);
    for (int z = 0; z < size; ++z)
        for (int y = 0; y < size; ++y)
            everywhere &= rows[y + size * z] = halo[std::size_t(y + side * z)] & low_bits(size);
    return everywhere == low_bits(size);
}

Share TouchedCells::changeable_rows(Vec3i brick, RowBits* rows) const {
    const int size = m_size, side = size + 1, all = size * size;
    std::array<int, 8> places;
    bool full = true;
    for (int c = 0; c < 8; ++c) {
        const int place = find(brick - Vec3i{c & 1, c >> 1 & 1, c >> 2});
        places[std::size_t(c)] = place;
        full &= place >= 0 && m_is_full[std::size_t(place)];
    }
    if (full || places[0] < 0) {
        std::fill_n(rows, all, full ? low_bits(size) : 0);
        return full ? Share::All : Share::None;
    }
    // Bit x + 1 of row (y + 1, z + 1) is the cell (x, y, z), each −1…size − 1.
    HaloRows halo;
    std::fill_n(halo.begin(), side * side, 0);
    for (int c = 0; c < 8; ++c) {
        if (places[std::size_t(c)] < 0) continue;
        const bool lx = c & 1, ly = c >> 1 & 1, lz = c >> 2;
        const RowBits* from = rows_of(places[std::size_t(c)]);
        for (int z = lz ? size - 1 : 0; z < size; ++z)
            for (int y = ly ? size - 1 : 0; y < size; ++y)
                halo[std::size_t((ly ? 0 : y + 1) + side * (lz ? 0 : z + 1))] |=
                    lx ? from[y + size * z] >> (size - 1) : from[y + size * z] << 1;
    }
    for (int r = 0; r < side * side; ++r) halo[std::size_t(r)] &= halo[std::size_t(r)] >> 1;
    for (int r = 0; r + 1 < side * side; ++r) halo[std::size_t(r)] &= halo[std::size_t(r + 1)];
    for (int r = 0; r < side * size; ++r) halo[std::size_t(r)] &= halo[std::size_t(r + side)];
    RowBits any = 0;
    for (int z = 0; z < size; ++z)
        for (int y = 0; y < size; ++y)
            any |= rows[y + size * z] = halo[std::size_t(y + side * z)] & low_bits(size);
    return any != 0 ? Share::Some : Share::None;
}

}  // namespace pliant
