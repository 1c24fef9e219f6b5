// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/snapshot.h"

#include <algorithm>
#include <functional>
#include <span>

#include "core/hash.h"
#include "resample/cell_kernel.h"

namespace pliant {
namespace {

constexpr int kRecordsPerTask = 64;

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
    list_records(lattice);
    index_records();
    const int size = lattice.brick_size();
    const auto middle = std::size_t(StripLayout(size).middle);
    m_words_per_brick = std::size_t(BitLayout<int>{size}.words());
    m_altered.resize(m_records.size() * m_words_per_brick);
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        for (auto n = std::size_t(begin); n < std::size_t(end); ++n) {
            BitWord* bits = m_altered.data() + n * m_words_per_brick;
            BrickRecord& record = m_records[n];
            if (record.u[0])
                for (int a = 0; a < 3; ++a) record.u_middle[a] = record.u[std::size_t(a)][middle];
            const int old = before.find(record.coord);
            if (old < 0 || before.m_records[std::size_t(old)].stamp != record.stamp) {
                with_bit_layout(size, [&](auto layout) { find_altered(record, layout, bits); });
                continue;
            }
            record.is_full = before.m_records[std::size_t(old)].is_full;
            std::copy_n(before.altered(old), m_words_per_brick, bits);
        }
    };
    // By reference: a copy of the captures would be allocated.
    arena.for_each(std::int64_t(m_records.size()), kRecordsPerTask, std::ref(task));
}

void Snapshot::list_records(const Lattice& lattice) {
    const int count = lattice.elements_per_brick();
    m_records.clear();
    m_has_edits = !lattice.all_edits().empty();
    lattice.for_each_brick([&](const Brick& brick) {
        // A drag keeps bricks for all that it may reach.
        if (is_at_rest(brick) && !brick.edits) return;
        m_records.push_back({brick.coord,
                             {brick.u[0], brick.u[1], brick.u[2]},
                             brick.edits,
                             stamp_of(&brick, brick.edits, count),
                             brick.u_min,
                             brick.u_max});
    });
    for (const auto& [coord, edits] : lattice.all_edits())
        if (lattice.find_brick(coord) < 0)
            m_records.push_back({coord,
                                 {},
                                 edits.data(),
                                 stamp_of(nullptr, edits.data(), count),
                                 {0, 0, 0},
                                 {0, 0, 0}});
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
