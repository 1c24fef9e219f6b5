// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes voxels, strip by strip of cells or slab by slab of the scan.
//
// Where the lattice hangs together and no cell is folded, φ maps the scan to itself one to one, and
// every voxel lies in one cell (on faces, half-open cells share out). So all threads take strips as
// they come, each strip once, and nobody meets. If there are folded cells, whatever lies in several
// cells lies in a folded one too (a voxel is covered once more from the right side than from the
// wrong one): the boxes around those are contested, and written again.
//
// What is contested, or beside cuts and carved cells, is divided by the place where it is written:
// a slab is some layers of bricks, one task. Each task visits the strips that may reach into its
// slab, in one fixed order, and the first cell to cover a voxel writes it. Either way the result
// doesn't depend on the number of threads.

#pragma once

#include <pliant/resample.h>

#include <array>
#include <atomic>
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

/// Opens once more what can change in some boxes of dirty bricks.
/// @param boxes  within a brick each; sorted by brick when it returns
void open_again(const ScatterJob& job, const CellTarget& target, std::vector<Box3i>& boxes);

class SlabWriter {
  public:
    /// Finds the voxels to write in the given bricks, opens them, and puts back all others.
    OpenVoxels open(const ScatterJob& job, const CellTarget& target, std::span<DirtyBrick> bricks);

    /// Writes strips until there are none left. Voxels on edges, and boxes around cells that may be
    /// folded, cut into bricks, stay behind: edge_voxels() and contested().
    /// @param next  strip that nobody has taken yet
    void write_strips(const ScatterJob& job, const CellTarget& target,
                      std::atomic<std::size_t>& next);
    const std::vector<EdgeVoxel>& edge_voxels() const { return m_left.edge; }
    const std::vector<Box3i>& contested() const { return m_contested; }

    /// Writes the open voxels of the bricks, which lie in target.box.
    /// @param left  most are written already
    /// @returns how many of them nothing covers; they become air
    std::int64_t write(const ScatterJob& job, const CellTarget& target,
                       std::span<const DirtyBrick> bricks, bool left);

  private:
    /// @param left  only strips that reach voxels that are still open
    void scatter(const ScatterJob& job, const CellTarget& target, Mapping mapping, CellFaces faces,
                 bool left);
    void write_cell(const ScatterJob& job, const CellTarget& target, Mapping mapping, int cell);
    std::array<Vec3d, 8> corners_of(const Lattice& lattice, int cell) const;
    Box3i box_of(int cell) const;
    void contest(const Box3i& voxels, int brick_size);

    StripNodes m_strip;
    Leftovers m_left;
    std::vector<Box3i> m_contested;
    bool m_met_slow = false;
};

}  // namespace pliant
