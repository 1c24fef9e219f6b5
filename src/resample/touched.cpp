// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/touched.h"

#include <algorithm>
#include <array>
#include <functional>
#include <type_traits>

namespace pliant {
namespace {

constexpr int kLargestBrick = 32, kUsualBrick = 8;
constexpr std::int64_t kBricksPerTask = 64;

/// Rows of a brick and of the layers beside it on one side: side = size + 1 of them along y and z.
/// A brick of usual size, known to the compiler, needs no more than two bytes a row.
template <class Size>
using HaloRow = std::conditional_t<std::is_same_v<Size, int>, RowBits, std::uint16_t>;
template <class Size>
using HaloRows =
    std::array<HaloRow<Size>, std::is_same_v<Size, int> ? (kLargestBrick + 1) * (kLargestBrick + 1)
                                                        : (kUsualBrick + 1) * (kUsualBrick + 1)>;

RowBits low_bits(int count) {
    return (RowBits(1) << count) - 1;
}

/// Calls work(size), with the usual size as a constant: loops over rows are unrolled then.
template <class Work>
auto with_size(int size, const Work& work) {
    return size == kUsualBrick ? work(std::integral_constant<int, kUsualBrick>()) : work(size);
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
            RowBits* rows = m_rows.data() + place * std::size_t(m_size * m_size);
            m_is_full[place] = with_size(m_size, [&](auto size) {
                return find_rows(snapshot, size, m_bricks[place], rows);
            });
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
template <class Size>
bool TouchedCells::find_rows(const Snapshot& snapshot, Size size, Vec3i brick,
                             RowBits* rows) const {
    const int side = size + 1, all = size * size;
    // A moved element touches all eight cells around it.
    const BrickRecord* record = snapshot.record_at(brick);
    if (record && record->is_full) {
        std::fill_n(rows, all, low_bits(size));
        return true;
    }
    // Elements first: bit x of row (y, z), each 0…size.
    HaloRows<Size> halo;
    std::fill_n(halo.begin(), side * side, 0);
    for (int c = 0; c < 8; ++c) {
        const int hx = c & 1, hy = c >> 1 & 1, hz = c >> 2;
        const int found = snapshot.find(brick + Vec3i{hx, hy, hz});
        if (found < 0) continue;
        const RowBits* from = snapshot.altered_rows(found);
        for (int z = 0; z < (hz ? 1 : size); ++z) {
            HaloRow<Size>* to = halo.data() + hy * size + side * (z + hz * size);
            for (int y = 0; y < (hy ? 1 : size); ++y)
                to[y] |= HaloRow<Size>(hx ? (from[y + size * z] & 1) << size : from[y + size * z]);
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
    return with_size(m_size, [&](auto size) { return find_changeable(size, brick, rows); });
}

template <class Size>
Share TouchedCells::find_changeable(Size size, Vec3i brick, RowBits* rows) const {
    const int side = size + 1, all = size * size;
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
    HaloRows<Size> halo;
    std::fill_n(halo.begin(), side * side, 0);
    for (int c = 0; c < 8; ++c) {
        if (places[std::size_t(c)] < 0) continue;
        const bool lx = c & 1, ly = c >> 1 & 1, lz = c >> 2;
        const RowBits* from = rows_of(places[std::size_t(c)]);
        for (int z = lz ? size - 1 : 0; z < size; ++z)
            for (int y = ly ? size - 1 : 0; y < size; ++y)
                halo[std::size_t((ly ? 0 : y + 1) + side * (lz ? 0 : z + 1))] |=
                    HaloRow<Size>(lx ? from[y + size * z] >> (size - 1) : from[y + size * z] << 1);
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

void TouchedCells::bound_changeable(Vec3i brick, RowBits* rows) const {
    with_size(m_size, [&](auto size) {
        const RowBits* cells = this->rows(brick);
        const int all = size * size;
        if (!cells) {
            std::fill_n(rows, all, 0);
            return;
        }
        for (int r = 0; r < all; ++r) rows[r] = cells[r] & (cells[r] << 1 | 1);
        for (int r = all - 1; r > 0; --r)
            if (r % size != 0) rows[r] &= rows[r - 1];
        for (int r = all - 1; r >= size; --r) rows[r] &= rows[r - size];
    });
}

}  // namespace pliant
