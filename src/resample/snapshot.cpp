// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/snapshot.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <span>

#include "core/hash.h"
#include "resample/cell_kernel.h"

namespace pliant {
namespace {

constexpr int kIndicesPerTask = 64;

/// A brick's clock, and its edits as they are: those of a brick at rest have no clock.
std::uint64_t stamp_of(const Brick* brick, const std::uint8_t* edits, int element_count) {
    const std::uint64_t clock = brick ? brick->changed_at + 1 : 0;
    if (!edits) return clock;
    Hash64 hash;
    hash.add_word(clock);
    hash.add(std::span(edits, std::size_t(element_count)));
    return hash.value();
}

bool moved_as_a_whole(const BrickRecord& record) {
    const Vec3<Fixed>&low = record.u_min, &high = record.u_max;
    return low.x > 0 || low.y > 0 || low.z > 0 || high.x < 0 || high.y < 0 || high.z < 0;
}

/// Components of displacement: the one that alone may say of all elements that they moved is first.
std::array<const Fixed*, 3> farthest_first(const BrickRecord& record) {
    std::array<const Fixed*, 3> u = record.u;
    const auto reach = [&](int a) {
        return std::max(-std::int64_t(record.u_min[a]), std::int64_t(record.u_max[a]));
    };
    int farthest = 0;
    for (int a = 1; a < 3; ++a)
        if (reach(a) > reach(farthest)) farthest = a;
    std::swap(u[0], u[std::size_t(farthest)]);
    return u;
}

/// Asks for what find_altered() will read: bricks lie anywhere in memory. Always inline, or the
/// compiler takes it for a function that does nothing.
[[gnu::always_inline]] inline void fetch(const BrickRecord& record, int size) {
    if (!record.u[0] || moved_as_a_whole(record)) return;
    constexpr int kLine = 64 / sizeof(Fixed);
    for (const Fixed* u : record.u)
        for (int i = 0; i < size * size * size; i += kLine) __builtin_prefetch(u + i, 0, 2);
}

template <class Size>
void find_altered(BrickRecord& record, const BitLayout<Size>& layout, BitWord* bits) {
    const int words = layout.words(), count = layout.elements_per_word();
    record.is_full = moved_as_a_whole(record);
    if (record.is_full) {
        std::fill_n(bits, words, layout.all());
        return;
    }
    if (record.u[0])
        find_moved(farthest_first(record), words, count, bits);
    else
        std::fill_n(bits, words, 0);
    if (record.edits)
        for (int w = 0; w < words; ++w)
            for (int i = 0; i < count; ++i)
                bits[w] |= BitWord((record.edits[i + count * w] & kVoid) != 0) << i;
    record.is_full =
        std::all_of(bits, bits + words, [&](BitWord word) { return word == layout.all(); });
}

}  // namespace

void Snapshot::take(const Lattice& lattice, const Snapshot& before, const TaskArena& arena) {
    m_words_per_brick = std::size_t(BitLayout<int>{lattice.brick_size()}.words());
    m_has_edits = !lattice.all_edits().empty();
    list_records(lattice, before, arena);
    index_records();
}

/// First counts the records of some bricks each, so that threads know where theirs go.
void Snapshot::list_records(const Lattice& lattice, const Snapshot& before,
                            const TaskArena& arena) {
    const int count = lattice.elements_per_brick();
    const std::int64_t tasks =
        (lattice.brick_index_bound() + kIndicesPerTask - 1) / kIndicesPerTask;
    const auto for_task = [&](std::int64_t task, const auto& visit) {
        const int begin = int(task) * kIndicesPerTask;
        lattice.for_each_brick(begin,
                               std::min(begin + kIndicesPerTask, lattice.brick_index_bound()),
                               [&](const Brick& brick) {
                                   // A drag keeps bricks for all that it may reach.
                                   if (!is_at_rest(brick) || brick.edits) visit(brick);
                               });
    };
    m_first_records.assign(std::size_t(tasks) + 1, 0);
    const auto count_some = [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t task = begin; task < end; ++task)
            for_task(task, [&](const Brick&) { ++m_first_records[std::size_t(task) + 1]; });
    };
    // By reference: a copy of the captures would be allocated.
    arena.for_each(tasks, 1, std::ref(count_some));
    std::partial_sum(m_first_records.begin(), m_first_records.end(), m_first_records.begin());
    const std::size_t of_bricks = m_first_records.back();
    m_records.resize(of_bricks);
    for (const auto& [coord, edits] : lattice.all_edits())
        if (lattice.find_brick(coord) < 0)
            m_records.push_back(
                {coord, {}, edits.data(), stamp_of(nullptr, edits.data(), count), {}, {}});
    m_altered.resize(m_records.size() * m_words_per_brick);
    const auto fill_some = [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t task = begin; task < end; ++task) {
            const std::size_t first = m_first_records[std::size_t(task)];
            std::size_t n = first;
            for_task(task, [&](const Brick& brick) {
                m_records[n++] = {brick.coord, {brick.u[0], brick.u[1], brick.u[2]},
                                  brick.edits, stamp_of(&brick, brick.edits, count),
                                  brick.u_min, brick.u_max};
            });
            fill(first, n, lattice.brick_size(), before);
        }
    };
    arena.for_each(tasks, 1, std::ref(fill_some));
    fill(of_bricks, m_records.size(), lattice.brick_size(), before);
}

/// Adds what has to be read from the bricks' elements.
void Snapshot::fill(std::size_t first, std::size_t end, int brick_size, const Snapshot& before) {
    const StripLayout strips(brick_size);
    for (std::size_t n = first; n < end; ++n) {
        BitWord* bits = m_altered.data() + n * m_words_per_brick;
        BrickRecord& record = m_records[n];
        if (n + 1 < end) fetch(m_records[n + 1], brick_size);
        const int in_strip = record.coord.x - strips.first_of(record.coord.x);
        if (record.u[0] && in_strip == strips.middle_brick)
            for (int a = 0; a < 3; ++a)
                record.u_middle[a] = record.u[std::size_t(a)][strips.middle];
        const int old = before.find(record.coord);
        if (old < 0 || before.m_records[std::size_t(old)].stamp != record.stamp) {
            with_bit_layout(brick_size, [&](auto layout) { find_altered(record, layout, bits); });
            continue;
        }
        const BrickRecord& same = before.m_records[std::size_t(old)];
        record.is_full = same.is_full;
        std::copy_n(before.altered(same), m_words_per_brick, bits);
    }
}

BlockRecords Snapshot::records_around(Vec3i coord) const {
    BlockRecords records;
    if (!contains(m_box, coord) || !contains(m_box, coord + Vec3i{1, 1, 1})) {
        for (int c = 0; c < 8; ++c)
            records[std::size_t(c)] = record_at(coord + Vec3i{c & 1, c >> 1 & 1, c >> 2});
        return records;
    }
    const Vec3i n = m_box.end - m_box.begin;
    const std::int32_t* at = m_record_at.data() + slot_of(coord);
    for (int c = 0; c < 8; ++c) {
        const std::int32_t found = at[(c & 1) + n.x * ((c >> 1 & 1) + n.y * (c >> 2))];
        records[std::size_t(c)] = found < 0 ? nullptr : &m_records[std::size_t(found)];
    }
    return records;
}

void Snapshot::index_records() {
    m_box = {};
    m_record_at.clear();
    if (m_records.empty()) return;
    m_box = {m_records[0].coord, m_records[0].coord};
    for (const BrickRecord& record : m_records)
        for (int a = 0; a < 3; ++a) {
            m_box.begin[a] = std::min(m_box.begin[a], record.coord[a]);
            m_box.end[a] = std::max(m_box.end[a], record.coord[a] + 1);
        }
    const Vec3i n = m_box.end - m_box.begin;
    m_record_at.assign(std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z), -1);
    for (std::size_t r = 0; r < m_records.size(); ++r)
        m_record_at[slot_of(m_records[r].coord)] = std::int32_t(r);
}

}  // namespace pliant
