// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Which triangles are near a box: space in cubes, each with the triangles whose boxes meet it.
// Cubes are numbered i + j N_x + k N_x N_y [VesselPbd2016, Eq. 10], so that no two share a number.
// Memory is kept from one filling to the next.

#pragma once

#include <pliant/mesh.h>

#include <cstdint>
#include <span>
#include <vector>

namespace pliant::pbd {

class TriangleGrid {
  public:
    /// Triangles as they are now, each with a margin all around.
    void fill(std::span<const Vec3d> places, std::span<const std::array<std::int32_t, 3>> triangles,
              double margin);

    /// All triangles that meet the box, and some others, in rising order.
    /// @param[out] found  is cleared first
    void near(Vec3d low, Vec3d high, std::vector<std::int32_t>& found) const;

  private:
    struct Range {
        Vec3i low, high;
    };
    Range cubes_of(Vec3d low, Vec3d high) const;
    std::size_t index_of(int i, int j, int k) const {
        return std::size_t(i) +
               std::size_t(m_size.x) * (std::size_t(j) + std::size_t(m_size.y) * std::size_t(k));
    }

    Vec3d m_origin{0, 0, 0};
    double m_cube = 1;
    Vec3i m_size{0, 0, 0};
    std::vector<std::int32_t> m_starts;   ///< [cube], and one more
    std::vector<std::int32_t> m_entries;  ///< triangles, cube by cube
    std::vector<Vec3i> m_lows;            ///< [triangle]: the first of its cubes
};

}  // namespace pliant::pbd
