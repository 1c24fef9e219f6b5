// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Keeps a grid up to date with a deformed lattice. The first update writes all that is deformed,
// each later one the bricks that cells which changed since then left or entered.

#pragma once

#include <pliant/resample.h>

#include <cstdlib>
#include <memory>
#include <vector>

#include "resample/slab_writer.h"

namespace pliant {

class Scatter {
  public:
    /// Keeps references. @param original  stays as it is; what is written starts as its copy
    Scatter(const Volume& original, const TaskArena& arena);

    /// Finds what has to be written. @returns the voxels that can change, in those bricks
    OpenVoxels look(const Lattice& lattice, Mapping mapping, Volume& deformed);
    /// Writes it. @param inverse_mm  over inverse_box; may be null
    /// @returns the number of gaps
    std::int64_t write(const Lattice& lattice, Mapping mapping, Volume& deformed, Vec3f* inverse_mm,
                       const Box3i& inverse_box);

    /// Boxes of voxels that the last update wrote: whole bricks, cut to the scan.
    const std::vector<Box3i>& written_boxes() const { return m_boxes; }

  private:
    /// Consecutive layers of bricks, and their part of m_bricks.
    struct Slab {
        int begin, end;
        std::size_t first_brick, last_brick;
        OpenVoxels open;
        std::int64_t gaps;
    };

    /// A brick's cells, of which some changed, and the voxels that they cover at most.
    struct ChangedBlock {
        Vec3i coord;
        Box3i before, now;
    };

    struct Free {
        void operator()(void* memory) const { std::free(memory); }
    };

    void write_strips(const ScatterJob& job, const CellTarget& target);
    void find_dirty(const Lattice& lattice);
    void mark_changes(const Lattice& lattice);
    void mark(Box3i voxels, int brick_size);
    void list_strips(const Lattice& lattice);
    void list_slabs();
    void list_boxes(int brick_size);
    CellTarget target_of(const Box3i& box, Volume& deformed);
    Box3i box_of(const Slab& slab, int brick_size) const;
    ScatterJob job_of(const Lattice& lattice, Mapping mapping) const;

    const Volume& m_original;
    const TaskArena& m_arena;
    Vec3i m_brick_count{0, 0, 0};
    Snapshot m_now, m_before;
    TouchedCells m_touched;                        ///< now
    std::vector<std::uint8_t> m_dirty, m_changed;  ///< per brick of the scan
    std::vector<std::uint8_t> m_block_flags;       ///< of the blocks in some box
    std::vector<ChangedBlock> m_changed_blocks;
    std::vector<DirtyBrick> m_bricks;
    std::vector<ReachingStrip> m_strips;
    std::vector<Slab> m_slabs;
    std::vector<SlabWriter> m_writers;
    std::vector<EdgeVoxel> m_edge;
    std::vector<Box3i> m_contested;
    std::unique_ptr<std::uint8_t[], Free> m_open;  ///< per voxel, all 0 between updates
    std::vector<Box3i> m_boxes;
};

/// Finds the changeable voxels of a scan and writes them: see deform_volume.
Deformed deform_by_lattice(const Volume& original, const Lattice& lattice, Mapping mapping,
                           bool with_inverse, const TaskArena& arena);

}  // namespace pliant
