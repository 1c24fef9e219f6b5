// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cells that a deformation moves, and voxels that it can change: one bit each, brick by brick.
//
// A cell is touched if one of its corners moved or is void. Untouched cells keep their positions,
// so the touched ones together cover at most their region at rest: a voxel can change only if all
// eight cells around it are touched.
//
// A brick's cells, named by their lowest corners, are a block: some of their corners are in
// neighbouring bricks.

#pragma once

#include "resample/snapshot.h"

namespace pliant {

/// Share of a brick's voxels.
enum class Share { None, Some, All };

/// Bounds of the present positions of some cells' corners [voxels], from the bounds of the bricks.
struct CellReach {
    Vec3d low, high;
};

class TouchedCells {
  public:
    void find(const Snapshot& snapshot, int brick_size, const TaskArena& arena);

    /// Bricks with touched cells, sorted by coordinate. A cell belongs to the brick of its lowest
    /// corner, which need not be among the snapshot's.
    const std::vector<Vec3i>& bricks() const { return m_bricks; }
    /// The brick's touched cells, named by their lowest corner; null: none
    const BitWord* cells(Vec3i brick) const {
        const int found = find(brick);
        return found < 0 ? nullptr : bits_of(found);
    }
    /// Reach of the blocks of some bricks in a row along x.
    CellReach reach(const Grid& grid, Vec3i first, int bricks) const;
    /// Finds the brick's voxels that can change.
    Share changeable(Vec3i brick, BitWord* voxels) const;

  private:
    /// Bounds of displacements.
    struct Bounds {
        Vec3<Fixed> low{0, 0, 0}, high{0, 0, 0};
    };

    void list_bricks(const Snapshot& snapshot);
    static Bounds bounds_of(const BlockRecords& records);
    std::size_t slot_of(Vec3i brick) const {
        const Vec3i p = brick - m_box.begin, n = m_box.end - m_box.begin;
        return std::size_t(p.x) +
               std::size_t(n.x) * (std::size_t(p.y) + std::size_t(n.y) * std::size_t(p.z));
    }
    int find(Vec3i brick) const { return contains(m_box, brick) ? m_index_of[slot_of(brick)] : -1; }
    const BitWord* bits_of(int index) const {
        return m_cells.data() + std::size_t(index) * m_words_per_brick;
    }

    int m_size = 0;
    Box3i m_box{};
    std::vector<std::int32_t> m_index_of;  ///< [slot of m_box]; −1: no touched cells
    std::vector<Vec3i> m_bricks;
    std::vector<BitWord> m_cells;
    std::size_t m_words_per_brick = 0;
    std::vector<std::uint8_t> m_is_full;
    std::vector<Bounds> m_bounds;  ///< of the blocks' corners
};

}  // namespace pliant
