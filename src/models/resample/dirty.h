// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bricks of the scan that must be written again: cells at changed elements cover them at rest,
// covered them before, or cover them now.

#pragma once

#include "resample/open_voxels.h"

namespace pliant {

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

}  // namespace pliant
