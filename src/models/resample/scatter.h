// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Updates a deformed scan from the lattice: finds the bricks of the scan that must be written
// again, opens the voxels in them that can change, lets strips of cells write these, and fills the
// gaps with air.

#pragma once

#include <pliant/resample.h>

#include <vector>

#include "resample/open_voxels.h"
#include "resample/strip_writer.h"

namespace pliant {

// Bricks of the scan that must be written again: cells at changed elements cover them at rest,
// covered them before, or cover them now.

/// Voxels of a box within reach, with a margin for rounding.
Box3i voxels_within(const CellReach& reach, const Box3i& within);

/// The lattice at one time, and the cells that it moves.
struct Motion {
    Snapshot snapshot;
    TouchedCells touched;
};

class Dirty {
  public:
    void find(const Grid& grid, int brick_size, const Motion& before, const Motion& now,
              const TaskArena& arena);

    /// Sorted by coordinate.
    std::vector<DirtyBrick>& bricks() { return m_bricks; }
    const std::vector<DirtyBrick>& bricks() const { return m_bricks; }
    /// [brick of the scan]
    std::span<const std::uint8_t> flags() const { return m_dirty; }
    Vec3i brick_count() const { return m_brick_count; }

  private:
    void mark_changes(const Grid& grid, int brick_size, const Motion& before, const Motion& now,
                      const TaskArena& arena);
    void widen_to_strips(const Grid& grid, int brick_size, const Motion& before, const Motion& now,
                         const Box3i& blocks);
    /// Threads may mark the same bricks.
    void mark(const Box3i& bricks);

    Vec3i m_brick_count{0, 0, 0};
    std::vector<std::uint8_t> m_dirty;        ///< [brick of the scan]
    std::vector<std::uint8_t> m_block_flags;  ///< flags of the blocks in a box
    std::vector<Vec3i> m_changed_blocks;      ///< blocks of cells with a change
    std::vector<DirtyBrick> m_bricks;
};

/// Voxels that can change.
struct OpenVoxels {
    std::int64_t count = 0;
    Box3i box;  ///< box around them
};

class Scatter {
  public:
    /// Keeps references. @param original  is not changed; the written volume starts as its copy
    Scatter(const Volume& original, const TaskArena& arena);

    /// Finds the voxels to write. @returns the voxels that can change, in the dirty bricks
    OpenVoxels look(const Field& field, Mapping mapping, Volume& deformed);
    /// Writes them. @param inverse_mm  over inverse_box; may be null
    /// @returns the number of gaps
    std::int64_t write(const Field& field, Mapping mapping, Volume& deformed, Vec3f* inverse_mm,
                       const Box3i& inverse_box);

    /// Sets φ⁻¹(p) − p to zero where write() will write, over the whole scan: for fields that are
    /// kept between updates. Must be called between look() and write().
    void clear_inverse(const Field& field, Vec3f* inverse_mm);
    /// Makes the next look() treat all deformed tissue as new.
    void forget() { m_now = {}; }
    /// Restores the scan's voxels, also after look() or write() has thrown, and sets inverse_mm to
    /// zero there. The next pair of calls writes all deformed voxels, and its boxes include the
    /// restored bricks. Doesn't allocate.
    /// @param inverse_mm  over the whole scan; may be null
    void start_over(Volume& deformed, Vec3f* inverse_mm) noexcept;
    const Snapshot& snapshot() const { return m_now.snapshot; }

    /// Boxes of voxels that the last update wrote: whole bricks, cut to the scan.
    const std::vector<Box3i>& written_boxes() const { return m_boxes; }

  private:
    void write_each_once(const ScatterJob& job, const CellTarget& target);
    void write_slabs(const ScatterJob& job, const CellTarget& target);
    bool open_contested(const ScatterJob& job, const CellTarget& target);
    void claim(const ScatterJob& job, const CellTarget& target, ClaimPass pass);
    std::int64_t write_claims(const CellTarget& target);
    void list_strips(const Field& field);
    void note_dirty();
    void list_boxes(int brick_size);
    void add_box(Vec3i brick, int brick_size);
    template <class Work>
    void for_dirty(const Work& work);
    template <class Work>
    void for_writers(const Work& work);
    CellTarget target_of(Volume& deformed);
    ScatterJob job_of(const Field& field, Mapping mapping) const;

    const Volume& m_original;
    const TaskArena& m_arena;
    Motion m_now, m_before;
    Dirty m_dirty;
    std::vector<ReachingStrip> m_strips;
    std::vector<StripWriter> m_writers;  ///< one for each thread
    std::vector<Claim> m_claims;
    std::int64_t m_opened = 0;  ///< number of voxels opened by the last look()
    OpenBoxes m_open_boxes;
    OpenMap m_open;
    /// [brick of the scan]: it differs from the scan, or a failed update began to write it.
    std::vector<std::uint8_t> m_differs;
    /// [brick of the scan]: it was restored since the last update.
    std::vector<std::uint8_t> m_put_back;
    bool m_has_put_back = false;
    std::vector<Box3i> m_boxes;
};

#pragma GCC visibility push(default)  // for other components
Deformed deform_by_field(const Volume& original, const Field& field, Mapping mapping,
                         bool with_inverse, const TaskArena& arena);
#pragma GCC visibility pop

}  // namespace pliant
