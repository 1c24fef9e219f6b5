// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The lattice at its last update of the grid: one record per brick that holds moved or carved
// elements. The difference of two snapshots, before and now, gives the voxels to write.

#pragma once

#include <pliant/core/tasks.h>

#include <array>
#include <cstdint>
#include <vector>

#include "field/field.h"
#include "resample/brick_bits.h"

namespace pliant {

/// Number of cells that are inverted together, for every vector width.
inline constexpr int kCellGroup = 16;

/// Bricks in a row along x: as many as fill a group of cells.
struct StripLayout {
    int bricks, middle_brick;
    int middle;  ///< index of an element of that brick

    explicit StripLayout(int brick_size)
        : bricks(brick_size < kCellGroup ? kCellGroup / brick_size : 1) {
        const int x = bricks * brick_size / 2, half = brick_size / 2;
        middle_brick = x / brick_size;
        middle = x % brick_size + brick_size * (half + brick_size * half);
    }
    /// First brick of the strip that holds a given one.
    int first_of(int brick_x) const {
        return brick_x >= 0 ? brick_x / bricks * bricks
                            : -((-brick_x + bricks - 1) / bricks) * bricks;
    }
};

struct BrickRecord {
    Vec3i coord;
    /// Displacements by axis; null if the brick is at rest, which is frequent beside displaced
    /// bricks. Valid until the brick changes
    std::array<const Fixed*, 3> u{};
    const std::uint8_t* edits = nullptr;  ///< null: none; valid likewise
    std::uint64_t stamp = 0;              ///< different for different displacements or edits
    Vec3<Fixed> u_min{0, 0, 0}, u_max{0, 0, 0};
    Vec3<Fixed> u_middle{0, 0, 0};  ///< at StripLayout::middle
    bool is_full = false;           ///< every element moved or is void

    Vec3<Fixed> displacement(int element) const {
        const auto along = [&](const Fixed* axis) { return axis ? axis[element] : 0; };
        return {along(u[0]), along(u[1]), along(u[2])};
    }
};

/// Records in the order of cell corners: c & 1, c >> 1 & 1, c >> 2.
using BlockRecords = std::array<const BrickRecord*, 8>;

class Snapshot {
  public:
    /// @param before  supplies the bits of unchanged bricks
    void take(const Field& field, const Snapshot& before, const TaskArena& arena);

    /// Sorted by coordinate.
    const std::vector<BrickRecord>& records() const { return m_records; }
    /// Box of the coordinates of all bricks with a record.
    const Box3i& box() const { return m_box; }
    /// @returns −1 if all elements of the brick are at rest and whole
    int find(Vec3i coord) const {
        return contains(m_box, coord) ? m_record_at[slot_of(coord)] : -1;
    }
    const BrickRecord* record_at(Vec3i coord) const {
        const int found = find(coord);
        return found < 0 ? nullptr : &m_records[std::size_t(found)];
    }
    /// Records of the bricks that hold the corners of a brick's cells; null: no record.
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
    /// Input of a record.
    struct Source {
        Vec3i coord;
        const FieldBrick* brick = nullptr;  ///< null: only edits
        const std::uint8_t* edits = nullptr;
        bool is_there() const { return brick || edits; }
    };

    void find_sources(const Field& field, const TaskArena& arena);
    void sort_sources();
    void fill(std::size_t first, std::size_t end, const Field& field, const Snapshot& before);

    std::vector<Source> m_sources;
    std::vector<std::int32_t> m_order;  ///< order of the sources by coordinate
    std::vector<BrickRecord> m_records;
    std::vector<BitWord> m_altered;
    std::size_t m_words_per_brick = 0;
    Box3i m_box;
    std::vector<std::int32_t> m_record_at;  ///< dense over m_box
    bool m_has_edits = false;
};

}  // namespace pliant
