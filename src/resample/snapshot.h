// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The lattice as it was when it was last written back to the grid: one record per brick that holds
// moved or carved elements. Two of them, before and now, say what has to be written again.

#pragma once

#include <pliant/tasks.h>

#include <array>
#include <cstdint>
#include <vector>

#include "chainmail/lattice.h"
#include "resample/brick_bits.h"

namespace pliant {

/// Cells that are inverted together, whatever the vector's width.
inline constexpr int kCellGroup = 16;

/// Bricks in a row along x: as many as it takes to fill a group of cells.
struct StripLayout {
    int bricks, middle_brick;
    int middle;  ///< index of an element of that brick

    explicit StripLayout(int brick_size)
        : bricks(brick_size < kCellGroup ? kCellGroup / brick_size : 1) {
        const int x = bricks * brick_size / 2, half = brick_size / 2;
        middle_brick = x / brick_size;
        middle = x % brick_size + brick_size * (half + brick_size * half);
    }
    /// First brick of the strip that holds one.
    int first_of(int brick_x) const {
        return brick_x >= 0 ? brick_x / bricks * bricks
                            : -((-brick_x + bricks - 1) / bricks) * bricks;
    }
};

struct BrickRecord {
    Vec3i coord;
    /// Of the brick, along each axis; null: at rest, as often beside what moves; valid until it
    /// changes
    std::array<const Fixed*, 3> u{};
    const std::uint8_t* edits = nullptr;  ///< null: none; likewise
    std::uint64_t stamp = 0;              ///< differs whenever displacements or edits do
    Vec3<Fixed> u_min{0, 0, 0}, u_max{0, 0, 0};
    Vec3<Fixed> u_middle{0, 0, 0};  ///< at StripLayout::middle
    bool is_full = false;           ///< every element moved or is void

    Vec3<Fixed> displacement(int element) const {
        const auto along = [&](const Fixed* axis) { return axis ? axis[element] : 0; };
        return {along(u[0]), along(u[1]), along(u[2])};
    }
};

/// Places in the same order as cell corners: c & 1, c >> 1 & 1, c >> 2.
using BlockRecords = std::array<const BrickRecord*, 8>;

class Snapshot {
  public:
    /// @param before  bits of bricks that didn't change are taken from it
    void take(const Lattice& lattice, const Snapshot& before, const TaskArena& arena);

    /// Sorted by coordinate.
    const std::vector<BrickRecord>& records() const { return m_records; }
    /// Coordinates of all bricks with a record lie in this box.
    const Box3i& box() const { return m_box; }
    /// @returns −1 if everything in the brick is at rest and whole
    int find(Vec3i coord) const {
        return contains(m_box, coord) ? m_record_at[slot_of(coord)] : -1;
    }
    const BrickRecord* record_at(Vec3i coord) const {
        const int found = find(coord);
        return found < 0 ? nullptr : &m_records[std::size_t(found)];
    }
    /// Those of the bricks that hold the corners of a brick's cells; null: as without a record.
    BlockRecords records_around(Vec3i coord) const;
    /// Elements that moved or are void.
    const BitWord* altered(const BrickRecord& record) const {
        return m_altered.data() + std::size_t(&record - m_records.data()) * m_words_per_brick;
    }
    bool has_edits() const { return m_has_edits; }

  private:
    std::size_t slot_of(Vec3i coord) const {
        const Vec3i p = coord - m_box.begin, n = m_box.end - m_box.begin;
        return std::size_t(p.x) +
               std::size_t(n.x) * (std::size_t(p.y) + std::size_t(n.y) * std::size_t(p.z));
    }
    /// What a record is made of.
    struct Source {
        Vec3i coord;
        const Brick* brick = nullptr;  ///< null: there are edits alone
        const std::uint8_t* edits = nullptr;
        bool is_there() const { return brick || edits; }
    };

    void find_sources(const Lattice& lattice, const TaskArena& arena);
    void sort_sources();
    void fill(std::size_t first, std::size_t end, const Lattice& lattice, const Snapshot& before);

    std::vector<Source> m_sources;
    std::vector<std::int32_t> m_order;  ///< of the sources: by coordinate
    std::vector<BrickRecord> m_records;
    std::vector<BitWord> m_altered;
    std::size_t m_words_per_brick = 0;
    Box3i m_box;
    std::vector<std::int32_t> m_record_at;  ///< dense over m_box
    bool m_has_edits = false;
};

}  // namespace pliant
