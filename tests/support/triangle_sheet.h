// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A flat surface.

#pragma once

#include <pliant/mesh.h>

#include <cmath>

namespace pliant::test {

/// A sheet in the plane z = 0 where each inner node has six neighbours [Choi2004, 4.1]: rows of
/// equilateral triangles, every second row shifted by half of a side.
/// @pre columns, rows ≥ 2
inline TriangleMesh triangle_sheet(int columns, int rows, double side_mm) {
    TriangleMesh mesh;
    const double height = std::sqrt(0.75) * side_mm;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
            mesh.nodes_mm.push_back({(i + 0.5 * (j % 2)) * side_mm, j * height, 0});
    for (int j = 0; j + 1 < rows; ++j)
        for (int i = 0; i + 1 < columns; ++i) {
            const std::int32_t a = i + columns * j, b = a + 1, c = a + columns, d = c + 1;
            if (j % 2 == 0)
                mesh.cells.insert(mesh.cells.end(), {{a, b, c}, {b, d, c}});
            else
                mesh.cells.insert(mesh.cells.end(), {{a, b, d}, {a, d, c}});
        }
    return mesh;
}

}  // namespace pliant::test
