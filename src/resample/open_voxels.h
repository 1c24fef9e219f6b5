// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Which voxels are still to be written: CellTarget::open, brick by brick of the scan. What can
// change is opened, whoever writes a voxel closes it, and what nobody covers is a
// gap. Each function works on some bricks, which different threads may share out.

#pragma once

#include <vector>

#include "resample/cell_kernel.h"
#include "resample/scatter_job.h"

namespace pliant {

/// A brick of the scan that has to be written again.
struct DirtyBrick {
    Vec3i coord;
    bool was_changed = false;  ///< held voxels that are not as in the scan
    std::int64_t opened = 0;   ///< voxels that can change
    Box3i open{};              ///< that holds those that are open
};

inline std::ptrdiff_t voxel_at(const CellTarget& target, Vec3i p) {
    return p.x +
           std::ptrdiff_t(target.grid_size.x) * (p.y + std::ptrdiff_t(target.grid_size.y) * p.z);
}
inline Vec3i voxel_place(const CellTarget& target, std::ptrdiff_t voxel) {
    const std::ptrdiff_t nx = target.grid_size.x, ny = target.grid_size.y;
    return {int(voxel % nx), int(voxel / nx % ny), int(voxel / (nx * ny))};
}
inline Open* open_at(const CellTarget& target, Vec3i p) {
    return target.open + voxel_at(target, p);
}

/// Opens the voxels that can change, and puts back all others. Threads may open different bricks.
void open_changeable(const ScatterJob& job, const CellTarget& target, OpenMap& map,
                     std::span<DirtyBrick> bricks);

/// Opens once more what can change in some boxes of dirty bricks, as shared. Boxes of threads may
/// overlap.
/// @param boxes  within a brick each
void open_again(const ScatterJob& job, const CellTarget& target, OpenMap& map,
                std::span<const Box3i> boxes);

/// Closes what is taken.
void close_taken(const CellTarget& target, std::span<const DirtyBrick> bricks);

/// Whether any voxel of a box is open, or shared.
/// @pre none is taken
bool any_open(const CellTarget& target, const Box3i& box);
bool any_shared(const CellTarget& target, const Box3i& box);

/// Finds the boxes around what is still open of what was.
void find_open(const ScatterJob& job, const CellTarget& target, std::span<DirtyBrick> bricks);

/// Makes what is open air. @returns how many voxels that are
std::int64_t fill_gaps(const CellTarget& target, std::span<const DirtyBrick> bricks);

/// Boxes of open voxels, by place.
class OpenBoxes {
  public:
    /// @param bricks  of the scan, along each axis. @returns whether anything is open
    bool list(std::span<const DirtyBrick> dirty, Vec3i bricks, int brick_size);
    /// Those parts of the boxes that lie in another one. @param[out] parts  replaced
    void within(const Box3i& voxels, std::vector<Box3i>& parts) const;

  private:
    Vec3i m_bricks{0, 0, 0};
    int m_brick_size = 0;
    std::vector<std::int32_t> m_at;  ///< per brick of the scan; −1: none
    std::vector<std::size_t> m_set;  ///< of m_at
    std::vector<Box3i> m_boxes;
};

}  // namespace pliant
