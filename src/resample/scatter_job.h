// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Common data of all code that writes a deformed scan: the writable voxels, and the strips of
// cells.

#pragma once

#include <pliant/resample.h>

#include <algorithm>
#include <span>

#include "resample/strip_nodes.h"

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

inline std::size_t dense_index(Vec3i p, Vec3i n) {
    return std::size_t(p.x) +
           std::size_t(n.x) * (std::size_t(p.y) + std::size_t(n.y) * std::size_t(p.z));
}
inline std::size_t dense_count(Vec3i n) {
    return std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z);
}

inline Box3i overlap(const Box3i& a, const Box3i& b) {
    Box3i both;
    for (int axis = 0; axis < 3; ++axis) {
        both.begin[axis] = std::max(a.begin[axis], b.begin[axis]);
        both.end[axis] = std::min(a.end[axis], b.end[axis]);
    }
    return both;
}

/// The smallest box around two boxes, each of which may be empty.
inline Box3i hull(const Box3i& a, const Box3i& b) {
    if (is_empty(a)) return b;
    if (is_empty(b)) return a;
    Box3i both;
    for (int axis = 0; axis < 3; ++axis) {
        both.begin[axis] = std::min(a.begin[axis], b.begin[axis]);
        both.end[axis] = std::max(a.end[axis], b.end[axis]);
    }
    return both;
}

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

template <class Visit>
void for_each_in(const Box3i& box, const Visit& visit) {
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            for (int x = box.begin.x; x < box.end.x; ++x) visit(Vec3i{x, y, z});
}

/// Visits the first voxel of each of a box's rows.
template <class Visit>
void for_each_row(const Box3i& box, const Visit& visit) {
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y) visit(Vec3i{box.begin.x, y, z});
}

}  // namespace pliant
