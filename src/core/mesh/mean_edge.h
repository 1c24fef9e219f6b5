// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mean length of the edges of tetrahedra, each counted once per tetrahedron.

#pragma once

#include <pliant/mesh.h>

#include <cstddef>

namespace pliant {

/// @pre the mesh has cells
inline double mean_edge_mm(const TetMesh& mesh) {
    double sum = 0;
    for (const auto& cell : mesh.cells)
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = a + 1; b < 4; ++b)
                sum +=
                    norm(mesh.nodes_mm[std::size_t(cell[a])] - mesh.nodes_mm[std::size_t(cell[b])]);
    return sum / (6.0 * double(mesh.cells.size()));
}

}  // namespace pliant
