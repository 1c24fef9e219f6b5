// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/touched.h"

#include <algorithm>
#include <array>
#include <functional>

#include "field/cell_block.h"

namespace pliant {
namespace {

constexpr std::int64_t kBricksPerTask = 64;
constexpr AnyBrickBits kNone{};

/// @returns whether all are touched
template <class Size>
bool find_cells(const Snapshot& snapshot, const BitLayout<Size>& layout,
                const BlockRecords& records, BitWord* cells) {
    // A moved element touches all eight cells around it.
    if (records[0] && records[0]->is_full) {
        std::fill_n(cells, layout.words(), layout.all());
        return true;
    }
    std::array<const BitWord*, 8> altered;
    for (std::size_t c = 0; c < 8; ++c)
        altered[c] = records[c] ? snapshot.altered(*records[c]) : kNone.data();
    combine_around<true>(layout, altered, std::bit_or<BitWord>(), cells);
    return std::all_of(cells, cells + layout.words(),
                       [&](BitWord word) { return word == layout.all(); });
}

}  // namespace

void TouchedCells::find(const Snapshot& snapshot, int brick_size, const TaskArena& arena) {
    m_size = brick_size;
    m_words_per_brick = std::size_t(BitLayout<int>{m_size}.words());
    list_bricks(snapshot);
    m_cells.resize(m_bricks.size() * m_words_per_brick);
    m_is_full.resize(m_bricks.size());
    m_bounds.resize(m_bricks.size());
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        with_bit_layout(m_size, [&](auto layout) {
            for (auto n = std::size_t(begin); n < std::size_t(end); ++n) {
                const BlockRecords records = snapshot.records_around(m_bricks[n]);
                m_bounds[n] = bounds_of(records);
                m_is_full[n] =
                    find_cells(snapshot, layout, records, m_cells.data() + n * m_words_per_brick);
            }
        });
    };
    // By reference: a copy of the captures would allocate.
    arena.for_each(std::int64_t(m_bricks.size()), kBricksPerTask, std::ref(task));
}

void TouchedCells::list_bricks(const Snapshot& snapshot) {
    m_bricks.clear();
    m_index_of.clear();
    m_box = {};
    if (snapshot.records().empty()) return;
    m_box = {snapshot.box().begin - Vec3i{1, 1, 1}, snapshot.box().end};
    const Vec3i n = m_box.end - m_box.begin;
    m_index_of.assign(std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z), -1);
    for (const BrickRecord& record : snapshot.records())
        for (int c = 0; c < 8; ++c)
            m_index_of[slot_of(record.coord - Vec3i{c & 1, c >> 1 & 1, c >> 2})] = 0;
    std::size_t slot = 0;
    for (int z = m_box.begin.z; z < m_box.end.z; ++z)
        for (int y = m_box.begin.y; y < m_box.end.y; ++y)
            for (int x = m_box.begin.x; x < m_box.end.x; ++x, ++slot) {
                if (m_index_of[slot] < 0) continue;
                m_index_of[slot] = std::int32_t(m_bricks.size());
                m_bricks.push_back({x, y, z});
            }
}

TouchedCells::Bounds TouchedCells::bounds_of(const BlockRecords& records) {
    Bounds bounds{{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};
    for (const BrickRecord* record : records)
        for (int a = 0; a < 3; ++a) {
            bounds.low[a] = std::min(bounds.low[a], record ? record->u_min[a] : 0);
            bounds.high[a] = std::max(bounds.high[a], record ? record->u_max[a] : 0);
        }
    return bounds;
}

CellReach TouchedCells::reach(const Grid& grid, Vec3i first, int bricks) const {
    const auto bounds_at = [&](int x) {
        const int index = find(first + Vec3i{x, 0, 0});
        return index < 0 ? Bounds{} : m_bounds[std::size_t(index)];
    };
    Bounds all = bounds_at(0);
    for (int x = 1; x < bricks; ++x) {
        const Bounds bounds = bounds_at(x);
        for (int a = 0; a < 3; ++a) {
            all.low[a] = std::min(all.low[a], bounds.low[a]);
            all.high[a] = std::max(all.high[a], bounds.high[a]);
        }
    }
    const Vec3d scale = voxels_per_unit(grid);
    const Vec3i begin = m_size * first, end = begin + m_size * Vec3i{bricks, 1, 1};
    CellReach reach;
    for (int a = 0; a < 3; ++a) {
        reach.low[a] = begin[a] + scale[a] * all.low[a];
        reach.high[a] = end[a] + scale[a] * all.high[a];
    }
    return reach;
}

Share TouchedCells::changeable(Vec3i brick, BitWord* voxels) const {
    std::array<const BitWord*, 8> cells;
    bool full = true;
    int own = -1;
    for (int c = 0; c < 8; ++c) {
        const int index = find(brick - Vec3i{c & 1, c >> 1 & 1, c >> 2});
        if (c == 0) own = index;
        cells[std::size_t(c)] = index < 0 ? kNone.data() : bits_of(index);
        full &= index >= 0 && m_is_full[std::size_t(index)];
    }
    return with_bit_layout(m_size, [&](auto layout) {
        const int words = layout.words();
        if (full || own < 0) {
            std::fill_n(voxels, words, full ? layout.all() : 0);
            return full ? Share::All : Share::None;
        }
        combine_around<false>(layout, cells, std::bit_and<BitWord>(), voxels);
        const bool any = std::any_of(voxels, voxels + words, [](BitWord word) { return word; });
        return any ? Share::Some : Share::None;
    });
}

}  // namespace pliant
