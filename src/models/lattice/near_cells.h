// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The deformed cells in a region of the scan, and the scan's values at their corners.

#pragma once

#include <pliant/volume.h>

#include <array>
#include <functional>
#include <tuple>

#include "lattice/lattice.h"

namespace pliant {

/// An order of elements that is independent of bricks: by z, y, x.
inline bool comes_before(Vec3i p, Vec3i q) {
    return std::tie(p.z, p.y, p.x) < std::tie(q.z, q.y, q.x);
}

/// A cell of the deformed lattice. Corners are numbered as in cell_block.h.
struct NearCell {
    Vec3i lowest;                  ///< element at its lowest corner
    std::array<Vec3d, 8> corners;  ///< present positions, relative to lowest [voxels]

    Vec3i element(std::size_t corner) const {
        const int c = int(corner);
        return lowest + Vec3i{c & 1, c >> 1 & 1, c >> 2};
    }
};

/// Calls visit(cell) for each cell, with at least one corner in the scan, whose bounding box meets
/// the box low…high [continuous voxel index]. The order depends on the bricks.
void visit_near_cells(const Lattice& lattice, Vec3d low, Vec3d high,
                      const std::function<void(const NearCell&)>& visit);

/// Whether the resampler draws the cell: it has no void corner and no open cut link.
bool is_whole(const Lattice& lattice, const NearCell& cell);

/// Largest displacement of all elements along each axis, in whole voxels rounded up.
Vec3i largest_movement(const Lattice& lattice);

/// The scan's own values; its background beyond the border.
class ScanValues {
  public:
    explicit ScanValues(const Volume& volume) : m_volume(volume) {}
    double at(Vec3i ijk) const {
        return contains(voxel_box(m_volume.grid), ijk) ? m_volume.at(ijk)
                                                       : double(m_volume.background);
    }
    std::array<double, 8> at_corners(const NearCell& cell) const {
        std::array<double, 8> values{};
        for (std::size_t c = 0; c < 8; ++c) values[c] = at(cell.element(c));
        return values;
    }

  private:
    const Volume& m_volume;
};

}  // namespace pliant
