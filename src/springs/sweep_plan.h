// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Plan of one contact's step: the nodes that move, renumbered so that the inner loop reads whole
// rows instead of single nodes.
//
//   local number   0…7   8 … 15   16 … 23   …                        frozen …      8 more
//                  pad   pack 0   pack 1    …  (each layer: whole packs)            pad
//
// A pack is eight nodes with consecutive numbers. Its links are sorted into slots of eight. If the
// other ends have consecutive numbers too, as mostly in a lattice, the slot is an offset and the
// kernel loads eight positions at once. All other links share slots with a list of eight numbers.
// Lanes without a link have stiffness 0. Equal slots of stiffness and length are stored once, so a
// uniform lattice needs one byte per link, and the data stay in the cache.
//
// Groups are swept in sequence. A slot selects old positions of its other ends, or new ones of an
// earlier group. Old and new positions are stored separately, so the result is independent of the
// order of packs in a group.

#pragma once

#include <pliant/springs.h>

#include <unordered_map>

#include "springs/aligned_array.h"

namespace pliant {

inline constexpr int kPack = 8;

/// Part of a plan whose nodes don't use each other's new positions.
struct SweepGroup {
    std::int32_t begin_pack, end_pack;
};

/// Eight links of a pack. 8 bytes.
struct SweepSlot {
    std::int32_t other;   ///< rows: local number of the other end − own; lists: first index in
                          ///< `others`
    std::uint32_t block;  ///< index in SweepPlan::blocks, in blocks
};

struct PackSlots {
    std::uint32_t begin, new_rows, rows_end;  ///< rows; from new_rows on they use new positions
    std::uint32_t new_lists, end;             ///< then lists, likewise
};

/// A cell with volume energy, in local numbers.
struct SweepCell {
    SpringCell cell;
    double rest_volume;
};
struct CellCorner {
    std::int32_t cell, corner;
};

struct SweepPlan {
    std::vector<std::int32_t> nodes;      ///< local → global; −1: padding
    std::vector<std::uint8_t> is_active;  ///< [local]; packs may contain a few inactive nodes
    std::int32_t active_end = kPack;      ///< higher local numbers are frozen
    std::int32_t active_nodes = 0;
    std::vector<SweepGroup> groups;
    std::vector<PackSlots> packs;
    std::vector<SweepSlot> slots;
    std::vector<std::int32_t> others;
    /// stiffness[8], stiffness·length[8], and with damping: damping/time step[8].
    AlignedArray blocks;
    bool damped = false;
    /// Volume energy: cells of each group, and the corners of each node.
    std::vector<SweepCell> cells;
    std::vector<std::int32_t> group_cells, first_group_cell;
    std::vector<CellCorner> corners;
    std::vector<std::int32_t> first_corner;  ///< [local − 8]

    std::size_t block_size() const { return damped ? 3 * kPack : 2 * kPack; }
    std::size_t local_count() const { return nodes.size(); }
};

/// Makes plans; reuses its memory.
class SweepPlanner {
  public:
    void plan(const SpringNetwork& network, const TransmittalOrder& layers, SeenPositions seen,
              double time_step, SweepPlan& plan);

  private:
    struct Slot {
        std::int32_t offset;
        bool sees_new;
        std::uint32_t lanes;
        std::int32_t link[kPack];
    };
    struct Left {
        std::int32_t local, link;
    };
    void add_group(const SpringNetwork& network, bool as_one, SweepPlan& plan);
    void sort_by_turn(const SpringNetwork& network, const TransmittalOrder& layers);
    void order_group(const SpringNetwork& network);
    void extend_rows(const SpringNetwork& network);
    void number(const SpringNetwork& network, SweepPlan& plan);
    void make_slots(const SpringNetwork& network, double time_step, SweepPlan& plan);
    /// @param first  local number of the first node of the pack's group
    void sort_links(const SpringNetwork& network, const SweepPlan& plan, std::int32_t pack,
                    std::int32_t first);
    int fewest_in_row() const;
    void add_rows(bool sees_new, const SpringNetwork& network, double time_step, SweepPlan& plan);
    void add_lists(bool sees_new, std::int32_t pack, const SpringNetwork& network, double time_step,
                   SweepPlan& plan);
    std::uint32_t block_of(const SpringNetwork& network, const std::int32_t (&links)[kPack],
                           double time_step, SweepPlan& plan);
    void add_cells(const SpringNetwork& network, SweepPlan& plan);
    void finish(const SpringNetwork& network, double time_step, SweepPlan& plan);

    std::vector<std::int32_t> m_local_of;  ///< [global]; −1 between calls
    std::vector<std::uint8_t> m_active;    ///< [global]; 0 between calls
    std::vector<std::int32_t> m_group, m_walk, m_frozen, m_cell_of;
    TransmittalOrder m_turns;  ///< nodes sorted by turn
    std::vector<Slot> m_slots;
    std::vector<Left> m_left[2][kPack];  ///< [sees new]
    std::unordered_map<std::uint64_t, std::uint32_t> m_block_of;
    std::vector<std::uint32_t> m_last_block;  ///< of the slot at this position in the previous pack
};

}  // namespace pliant
