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
// Old and new positions are stored separately, so the result is independent of the order of packs.

#pragma once

#include <pliant/models/springs.h>

#include <unordered_map>

#include "base/aligned_array.h"

namespace pliant {

inline constexpr int kPack = 8;

/// Eight links of a pack. 8 bytes.
struct SweepSlot {
    std::int32_t other;   ///< rows: local number of the other end − own; lists: first index in
                          ///< `others`
    std::uint32_t block;  ///< index in SweepPlan::blocks, in blocks
};

struct PackSlots {
    std::uint32_t begin, rows_end, end;  ///< rows, then lists
};

/// Eight cells with volume energy, all tetrahedra or all hexahedra. 8 bytes.
struct CellPack {
    std::int32_t first;  ///< corner c of cell `lane` is cell_nodes[first + kPack·c + lane]
    std::int32_t node_count;
};

struct SweepPlan {
    std::vector<std::int32_t> nodes;      ///< local → global; −1: padding
    std::vector<std::uint8_t> is_active;  ///< [local]; packs may contain a few inactive nodes
    std::int32_t active_end = kPack;      ///< higher local numbers are frozen
    std::int32_t active_nodes = 0;
    std::vector<PackSlots> packs;
    std::vector<SweepSlot> slots;
    std::vector<std::int32_t> others;
    /// stiffness[8], stiffness·length[8]; with damping also damping/time step[8]; with branches
    /// also length[8] and those of MaxwellBranch (state.h): pull[8], keep[8], gain[8].
    AlignedArray blocks;
    bool damped = false, branched = false;
    std::vector<std::int32_t> slot_links;  ///< with branches: [8 · slot + lane] link, or −1
    /// Volume energy of all cells of the active nodes. Lanes without a cell have bulk 0.
    std::vector<CellPack> cell_packs;
    std::vector<std::int32_t> cell_nodes;  ///< local numbers
    AlignedArray cell_values;              ///< of each pack: bulk[8], volume at rest[8]
    /// Corners of each node, as indices in cell_nodes; in the order of SpringNetwork::cells_of.
    std::vector<std::int32_t> corners, first_corner;  ///< first_corner: [local − 8], and the total

    std::size_t block_size() const { return kPack * (branched ? 7 : damped ? 3 : 2); }
    std::size_t local_count() const { return nodes.size(); }
};

/// Makes plans; reuses its memory.
class SweepPlanner {
  public:
    void plan(const SpringNetwork& network, std::span<const std::int32_t> nodes, double time_step,
              SweepPlan& plan);

  private:
    struct Slot {
        std::int32_t offset;
        std::uint32_t lanes;
        std::int32_t link[kPack];
    };
    struct Left {
        std::int32_t local, link;
    };
    void add_nodes(const SpringNetwork& network, SweepPlan& plan);
    void order_nodes(const SpringNetwork& network);
    void extend_rows(const SpringNetwork& network);
    void number(const SpringNetwork& network, SweepPlan& plan);
    void make_slots(const SpringNetwork& network, double time_step, SweepPlan& plan);
    void sort_links(const SpringNetwork& network, const SweepPlan& plan, std::int32_t pack);
    int fewest_in_row() const;
    void merge_rows();
    void add_rows(const SpringNetwork& network, double time_step, SweepPlan& plan);
    void add_lists(std::int32_t pack, const SpringNetwork& network, double time_step,
                   SweepPlan& plan);
    std::uint32_t block_of(const SpringNetwork& network, const std::int32_t (&links)[kPack],
                           double time_step, SweepPlan& plan);
    void add_cells(const SpringNetwork& network, SweepPlan& plan);
    /// Collects the cells of the active nodes in m_cells[tetrahedra, hexahedra].
    void find_cells(const SpringNetwork& network, const SweepPlan& plan);
    void add_cell_packs(const SpringNetwork& network, std::span<const std::int32_t> cells,
                        std::int32_t node_count, SweepPlan& plan);

    std::vector<std::int32_t> m_local_of;  ///< [global]; −1 between calls
    std::vector<std::uint8_t> m_active;    ///< [global]; 0 between calls
    std::vector<std::int32_t> m_nodes, m_walk, m_frozen;
    std::vector<std::int32_t> m_cell_of;   ///< [cell] index in cell_nodes, −1: none
    std::vector<std::int32_t> m_cells[2];  ///< tetrahedra, hexahedra
    std::vector<Slot> m_slots;
    std::vector<Left> m_left[kPack];
    std::vector<Left> m_merged;
    std::int32_t m_first_lane = 0;  ///< local number of the pack's first node
    std::unordered_map<std::uint64_t, std::uint32_t> m_block_of;
    std::vector<std::uint32_t> m_last_block;  ///< of the slot at this position in the previous pack
};

}  // namespace pliant
