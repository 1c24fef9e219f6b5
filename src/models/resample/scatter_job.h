// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Common data of all code that writes a deformed scan: the writable voxels, and the strips of
// cells.

#pragma once

#include <pliant/resample.h>

#include <algorithm>
#include <span>

#include "resample/strip_nodes.h"
#include "volume/boxes.h"

namespace pliant {

/// A strip of cells, named by its first brick, and the voxels that it may cover.
struct ReachingStrip {
    Vec3i coord;
    CellReach reach;
    Box3i voxels;  ///< of the scan, within reach
};

struct ScatterJob {
    const Volume& original;
    const Field& field;
    const Snapshot& snapshot;
    const TouchedCells& touched;
    Mapping mapping;
    std::span<const ReachingStrip> strips;  ///< sorted by coordinate
    std::span<const std::uint8_t> dirty;    ///< per brick of the scan
    Vec3i bricks;                           ///< number of bricks along each axis of the scan

    /// Whether cells may be missing, so that two without a common face may hold one voxel.
    bool has_gaps() const { return snapshot.has_edits() || field.is_void({-1, 0, 0}); }
};

/// The bricks that hold voxels of a box.
inline Box3i bricks_of(const Box3i& voxels, int brick_size) {
    Box3i bricks;
    for (int a = 0; a < 3; ++a) {
        bricks.begin[a] = voxels.begin[a] / brick_size;
        bricks.end[a] = (voxels.end[a] - 1) / brick_size + 1;
    }
    return bricks;
}

inline Box3i box_of_brick(const Grid& grid, Vec3i coord, int brick_size) {
    const Vec3i first = brick_size * coord;
    return overlap({first, first + Vec3i{brick_size, brick_size, brick_size}}, voxel_box(grid));
}

}  // namespace pliant
