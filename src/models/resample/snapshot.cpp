// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/snapshot.h"

#include <algorithm>
#include <climits>
#include <functional>
#include <span>

#include "base/hash.h"
#include "resample/node_kernel.h"

namespace pliant {
namespace {

constexpr int kIndicesPerTask = 64, kRecordsPerTask = 64;

/// Combines a brick's clock with its edits: a brick at rest with edits has no clock.
std::uint64_t stamp_of(const FieldBrick* brick, const std::uint8_t* edits, int element_count) {
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

/// Components of displacement. The first is the one that can prove for all elements that they
/// moved.
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

/// Prefetches the input of find_altered(): bricks lie anywhere in memory. Always inline, because
/// the compiler would remove the call of a function without visible effect.
[[gnu::always_inline]] inline void fetch(const BrickRecord& record, int size) {
    if (moved_as_a_whole(record)) return;
    constexpr int kLine = 64 / sizeof(Fixed);
    for (const Fixed* u : record.u)
        for (int i = 0; u && i < size * size * size; i += kLine) __builtin_prefetch(u + i, 0, 2);
}

template <class Size>
void find_altered(BrickRecord& record, const BitLayout<Size>& layout, BitWord* bits) {
    const int words = layout.words(), count = layout.elements_per_word();
    record.is_full = moved_as_a_whole(record);
    if (record.is_full) {
        std::fill_n(bits, words, layout.all());
        return;
    }
    find_moved(farthest_first(record), words, count, bits);
    if (record.edits)
        for (int w = 0; w < words; ++w)
            for (int i = 0; i < count; ++i)
                bits[w] |= BitWord((record.edits[i + count * w] & kVoid) != 0) << i;
    record.is_full =
        std::all_of(bits, bits + words, [&](BitWord word) { return word == layout.all(); });
}

}  // namespace

void Snapshot::take(const Field& field, const Snapshot& before, const TaskArena& arena) {
    m_words_per_brick = std::size_t(BitLayout<int>{field.brick_size()}.words());
    m_has_edits = !field.all_edits().empty();
    find_sources(field, arena);
    sort_sources();
    m_records.resize(m_order.size());
    m_altered.resize(m_order.size() * m_words_per_brick);
    const auto fill_some = [&](std::int64_t begin, std::int64_t end) {
        fill(std::size_t(begin), std::size_t(end), field, before);
    };
    // By reference: a copy of the captures would allocate.
    arena.for_each(std::int64_t(m_records.size()), kRecordsPerTask, std::ref(fill_some));
}

/// Finds the inputs of records, in unspecified order and with unused entries.
void Snapshot::find_sources(const Field& field, const TaskArena& arena) {
    const int bricks = field.brick_index_bound();
    m_sources.resize(std::size_t(bricks));
    const auto find_some = [&](std::int64_t begin, std::int64_t end) {
        Source* to = m_sources.data() + begin;
        field.for_each_brick(int(begin), int(end), [&](const FieldBrick& brick) {
            // During a drag bricks exist for all elements in its reach.
            if (!is_at_rest(brick) || brick.edits) *to++ = {brick.coord, &brick, brick.edits};
        });
        std::fill(to, m_sources.data() + end, Source{});
    };
    arena.for_each(bricks, kIndicesPerTask, std::ref(find_some));
    for (const auto& [coord, edits] : field.all_edits())
        if (field.find_brick(coord) < 0) m_sources.push_back({coord, nullptr, edits.data()});
}

/// Sorts them by coordinate: records of adjacent bricks are then adjacent in memory.
void Snapshot::sort_sources() {
    m_box = {{INT_MAX, INT_MAX, INT_MAX}, {INT_MIN, INT_MIN, INT_MIN}};
    for (const Source& source : m_sources) {
        if (!source.is_there()) continue;
        for (int a = 0; a < 3; ++a) {
            m_box.begin[a] = std::min(m_box.begin[a], source.coord[a]);
            m_box.end[a] = std::max(m_box.end[a], source.coord[a] + 1);
        }
    }
    m_order.clear();
    m_record_at.clear();
    if (is_empty(m_box)) {
        m_box = {};
        return;
    }
    const Vec3i n = m_box.end - m_box.begin;
    m_record_at.assign(std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z), -1);
    for (std::size_t s = 0; s < m_sources.size(); ++s)
        if (m_sources[s].is_there()) m_record_at[slot_of(m_sources[s].coord)] = std::int32_t(s);
    for (std::int32_t& at : m_record_at) {
        if (at < 0) continue;
        m_order.push_back(at);
        at = std::int32_t(m_order.size()) - 1;
    }
}

void Snapshot::fill(std::size_t first, std::size_t end, const Field& field,
                    const Snapshot& before) {
    const int size = field.brick_size();
    for (std::size_t n = first; n < end; ++n) {
        const Source& source = m_sources[std::size_t(m_order[n])];
        BrickRecord& record = m_records[n];
        record = {.coord = source.coord, .edits = source.edits};
        record.stamp = stamp_of(source.brick, source.edits, field.elements_per_brick());
        if (!source.brick) continue;
        record.u_min = source.brick->u_min;
        record.u_max = source.brick->u_max;
        for (int a = 0; a < 3; ++a)
            if (record.u_min[a] != 0 || record.u_max[a] != 0)
                record.u[std::size_t(a)] = source.brick->u[std::size_t(a)];
    }
    const StripLayout strips(size);
    for (std::size_t n = first; n < end; ++n) {
        BitWord* bits = m_altered.data() + n * m_words_per_brick;
        BrickRecord& record = m_records[n];
        if (n + 1 < end) fetch(m_records[n + 1], size);
        const int in_strip = record.coord.x - strips.first_of(record.coord.x);
        if (in_strip == strips.middle_brick) record.u_middle = record.displacement(strips.middle);
        const int old = before.find(record.coord);
        if (old < 0 || before.m_records[std::size_t(old)].stamp != record.stamp) {
            with_bit_layout(size, [&](auto layout) { find_altered(record, layout, bits); });
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

}  // namespace pliant
