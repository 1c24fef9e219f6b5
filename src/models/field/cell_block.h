// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The cells of the deformed lattice, brick by brick.
//
// A cell is the hexahedron between eight neighbouring elements, and belongs to the brick of its
// lowest corner:
//
//       6-------7        corner c of the cell at element e is element
//      /|      /|          e + (c & 1, c >> 1 & 1, c >> 2)
//     4-------5 |
//     | 2-----|-3        x to the right, y into the page, z up
//     |/      |/
//     0-------1
//
// A CellBlock holds the displacements of a brick's elements and of the next layer on the high
// sides: the data of all its cells and of all links that start in it.

#pragma once

#include <array>
#include <vector>

#include "field/field.h"

namespace pliant {

class CellBlock {
  public:
    /// Loads the block of brick `coord`, which may be missing itself.
    void load(const Field& field, Vec3i coord);

    Vec3i first_element() const { return m_first; }
    int size() const { return m_size; }
    /// Index of a local element 0…size along each axis.
    int index(int x, int y, int z) const { return x + m_row * (y + m_row * z); }
    Vec3<Fixed> displacement(int index) const {
        const auto n = std::size_t(index);
        return {m_u[0][n], m_u[1][n], m_u[2][n]};
    }
    bool is_moved(int index) const { return m_moved[std::size_t(index)] != 0; }
    /// Whether a corner of the cell whose lowest corner has this index moved.
    bool is_touched(int index) const { return m_touched[std::size_t(index)] != 0; }
    /// Indices of the corners of the cell whose lowest corner is (x, y, z), each in 0…size−1.
    std::array<int, 8> corners(int x, int y, int z) const {
        const int n = index(x, y, z), slice = m_row * m_row;
        return {n,         n + 1,         n + m_row,         n + m_row + 1,
                n + slice, n + slice + 1, n + slice + m_row, n + slice + m_row + 1};
    }

  private:
    void copy_from_brick(const Field& field, const FieldBrick& brick, Vec3i offset);
    void find_touched();

    Vec3i m_first{0, 0, 0};
    int m_size = 0, m_row = 0;
    std::array<std::vector<Fixed>, 3> m_u;
    std::vector<unsigned char> m_moved, m_touched;
};

/// Coordinates of all blocks that can hold a moved corner, sorted: independent of the history.
std::vector<Vec3i> cell_blocks(const Field& field);

/// Bounds of the displacements in a block, without loading it.
void bound_block(const Field& field, Vec3i coord, Vec3<Fixed>& lowest, Vec3<Fixed>& highest);

/// The deformed cell's corners relative to its lowest element at rest [voxels].
inline std::array<Vec3d, 8> deformed_corners(const CellBlock& block,
                                             const std::array<int, 8>& corners,
                                             Vec3d voxels_per_unit) {
    std::array<Vec3d, 8> points{};
    for (int c = 0; c < 8; ++c) {
        const Vec3<Fixed> u = block.displacement(corners[std::size_t(c)]);
        points[std::size_t(c)] = {(c & 1) + voxels_per_unit.x * u.x,
                                  (c >> 1 & 1) + voxels_per_unit.y * u.y,
                                  (c >> 2) + voxels_per_unit.z * u.z};
    }
    return points;
}

/// Voxels per fixed-point unit along each axis of a grid.
inline Vec3d voxels_per_unit(const Grid& grid) {
    const Vec3d h = grid.spacing_mm;
    return {1 / (h.x * kUnitsPerMm), 1 / (h.y * kUnitsPerMm), 1 / (h.z * kUnitsPerMm)};
}

}  // namespace pliant
