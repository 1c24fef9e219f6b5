// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Uniform grid for finding triangles near a box: each cube lists the triangles whose bounding boxes
// intersect it. Cubes have unique numbers i + j N_x + k N_x N_y [VesselPbd2016, Eq. 10]. Memory is
// reused.

#pragma once

#include <pliant/mesh.h>

#include <cstdint>
#include <span>
#include <vector>

#include "volume/boxes.h"

namespace pliant::pbd {

class TriangleGrid {
  public:
    /// Fills the grid with the triangles' present positions and a margin.
    void fill(std::span<const Vec3d> positions,
              std::span<const std::array<std::int32_t, 3>> triangles, double margin);

    /// Finds all triangles that intersect the box, and some others, in ascending order.
    /// @param[out] found  is cleared first
    void near(Vec3d low, Vec3d high, std::vector<std::int32_t>& found) const;

  private:
    struct Range {
        Vec3i low, high;
    };
    Range cubes_of(Vec3d low, Vec3d high) const;
    std::size_t index_of(int i, int j, int k) const { return dense_index({i, j, k}, m_size); }

    Vec3d m_origin{0, 0, 0};
    double m_cube = 1;
    Vec3i m_size{0, 0, 0};
    std::vector<std::int32_t> m_starts;   ///< [cube], and the total
    std::vector<std::int32_t> m_entries;  ///< triangles, cube by cube
    std::vector<Vec3i> m_lows;            ///< [triangle]: its first cube
};

}  // namespace pliant::pbd
