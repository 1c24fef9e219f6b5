// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Dräger's symmetric split of a deformed cell into twelve tetrahedra around its centre, and
// barycentric coordinates in them [Draeger2005, 3.6.3, Eqs. 3.1–3.4].
//
// Opposite faces are cut along parallel diagonals, so neighbouring cells have the same triangles on
// every face, and the tetrahedra of all cells fill space without gaps.

#pragma once

#include <pliant/core/vec.h>

#include <array>
#include <optional>

namespace pliant {

/// The corners (numbered as in cell_block.h) of the triangle that each tetrahedron spans with the
/// centre.
inline constexpr std::array<std::array<int, 3>, 12> kCellTriangles = {{
    {0, 1, 3},
    {0, 3, 2},
    {4, 5, 7},
    {4, 7, 6},  // z = 0, z = 1: diagonals 0–3 and 4–7
    {0, 1, 5},
    {0, 5, 4},
    {2, 3, 7},
    {2, 7, 6},  // y = 0, y = 1: 0–5 and 2–7
    {0, 2, 6},
    {0, 6, 4},
    {1, 3, 7},
    {1, 7, 5},  // x = 0, x = 1: 0–6 and 1–7
}};

/// A point of a deformed cell as a combination of its corners and its centre.
struct CellWeights {
    int triangle;                   ///< index into kCellTriangles
    std::array<double, 4> weights;  ///< of the centre, then of the triangle's corners; sum 1
};

/// Finds the tetrahedron that holds a point; each weight may be negative by the tolerance.
/// Tetrahedra flatter than 1e-12 of a voxel's volume are skipped.
/// @returns nothing if the point is outside of the cell
std::optional<CellWeights> locate_in_tetrahedra(const std::array<Vec3d, 8>& corners, Vec3d point,
                                                double tolerance);

/// Applies the combination to values at the corners; the centre has their mean.
template <class T>
T combine(const CellWeights& where, const std::array<T, 8>& values) {
    T mean = values[0];
    for (std::size_t c = 1; c < 8; ++c) mean = mean + values[c];
    T result = (where.weights[0] / 8) * mean;
    const auto& triangle = kCellTriangles[std::size_t(where.triangle)];
    for (std::size_t k = 0; k < 3; ++k)
        result = result + where.weights[k + 1] * values[std::size_t(triangle[k])];
    return result;
}

}  // namespace pliant
