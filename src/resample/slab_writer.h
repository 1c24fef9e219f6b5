// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes the voxels of a slab: some layers of bricks, one task.
//
// Work is divided by the place where it is written. Each task visits the strips of cells that may
// reach into its slab, in one fixed order, and the first cell to cover a voxel writes it; so no two
// threads write one voxel, and the result doesn't depend on their number.

#pragma once

#include <pliant/resample.h>

#include <vector>

#include "resample/cell_kernel.h"

namespace pliant {

/// Voxels that can change.
struct OpenVoxels {
    std::int64_t count = 0;
    Box3i box;  ///< that holds them all
};

/// A brick of the scan that has to be written again.
struct DirtyBrick {
    Vec3i coord;
    bool was_changed;  ///< holds voxels that are not as in the scan
    bool is_changeable = false;
};

/// A strip of cells, named by its first brick, and the voxels that it may cover.
struct ReachingStrip {
    Vec3i coord;
    CellReach reach;
    Box3i voxels;  ///< of the scan, within reach
};

/// What all slabs share.
struct ScatterJob {
    const Volume& original;
    const Lattice& lattice;
    const Snapshot& snapshot;
    const TouchedCells& touched;
    Mapping mapping;
    std::span<const ReachingStrip> strips;  ///< sorted by coordinate
    std::span<const std::uint8_t> dirty;    ///< per brick of the scan
    Vec3i bricks;                           ///< of the scan
};

class SlabWriter {
  public:
    /// Finds the voxels to write in the given bricks, opens them, and puts back all others.
    OpenVoxels open(const ScatterJob& job, const CellTarget& target, std::span<DirtyBrick> bricks);

    /// Writes the open voxels of the bricks, which lie in target.box.
    /// @returns how many of them nothing covers; they become air
    std::int64_t write(const ScatterJob& job, const CellTarget& target,
                       std::span<const DirtyBrick> bricks);

  private:
    /// @param left  only strips that reach voxels that are still open
    void scatter(const ScatterJob& job, const CellTarget& target, Mapping mapping, CellFaces faces,
                 bool left);
    void write_cell(const ScatterJob& job, const CellTarget& target, Mapping mapping, int cell);

    StripNodes m_strip;
    std::vector<int> m_slow;
    bool m_met_slow = false;
};

}  // namespace pliant
