// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Voxels that are still to be written: CellTarget::open, brick by brick of the scan. Voxels that
// can change are opened, a write closes them, and open voxels that no cell covers are gaps. Each
// function processes some bricks, which different threads may share out.

#pragma once

#include <vector>

#include "resample/cell_kernel.h"
#include "resample/scatter_job.h"

namespace pliant {

/// A brick of the scan that must be written again.
struct DirtyBrick {
    Vec3i coord;
    bool was_changed = false;  ///< held voxels that differ from the scan
    std::int64_t opened = 0;   ///< number of voxels that can change
    Box3i open{};              ///< box around the open voxels
};

inline std::ptrdiff_t voxel_at(const CellTarget& target, Vec3i p) {
    return p.x +
           std::ptrdiff_t(target.grid_size.x) * (p.y + std::ptrdiff_t(target.grid_size.y) * p.z);
}
inline Vec3i voxel_position(const CellTarget& target, std::ptrdiff_t voxel) {
    const std::ptrdiff_t nx = target.grid_size.x, ny = target.grid_size.y;
    return {int(voxel % nx), int(voxel / nx % ny), int(voxel / (nx * ny))};
}
inline Open* open_at(const CellTarget& target, Vec3i p) {
    return target.open + voxel_at(target, p);
}

/// Opens the voxels that can change, and restores all others. Threads may open different bricks.
void open_changeable(const ScatterJob& job, const CellTarget& target, OpenMap& map,
                     std::span<DirtyBrick> bricks);

/// Opens the changeable voxels in some boxes of dirty bricks again, as shared. Boxes of threads may
/// overlap.
/// @param boxes  each within one brick
void open_again(const ScatterJob& job, const CellTarget& target, OpenMap& map,
                std::span<const Box3i> boxes);

/// Closes taken voxels.
void close_taken(const CellTarget& target, std::span<const DirtyBrick> bricks);

/// Whether any voxel of a box is open, or shared.
/// @pre none is taken
bool any_open(const CellTarget& target, const Box3i& box);
bool any_shared(const CellTarget& target, const Box3i& box);

/// Finds the boxes around the remaining open voxels.
void find_open(const ScatterJob& job, const CellTarget& target, std::span<DirtyBrick> bricks);

/// Sets open voxels to air. @returns the number of these voxels
std::int64_t fill_gaps(const CellTarget& target, std::span<const DirtyBrick> bricks);

/// Boxes of open voxels, searchable by position.
class OpenBoxes {
  public:
    /// @param bricks  of the scan, along each axis. @returns whether anything is open
    bool list(std::span<const DirtyBrick> dirty, Vec3i bricks, int brick_size);
    /// Intersections of the boxes with another one. @param[out] parts  replaced
    void within(const Box3i& voxels, std::vector<Box3i>& parts) const;

  private:
    Vec3i m_bricks{0, 0, 0};
    int m_brick_size = 0;
    std::vector<std::int32_t> m_at;  ///< [brick of the scan]; −1: none
    std::vector<std::size_t> m_set;  ///< set entries of m_at
    std::vector<Box3i> m_boxes;
};

}  // namespace pliant
