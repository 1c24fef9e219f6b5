// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Masses of nodes from a density: each cell distributes its mass equally to its corners.

#pragma once

#include "springs/cell_volume.h"

namespace pliant {

inline void spread_masses(SpringParts& parts, double density) {
    for (SpringNode& node : parts.nodes) node.mass = 0;
    for (const SpringCell& cell : parts.cells) {
        const double volume =
            cell_volume(cell, [&](std::int32_t n) { return parts.nodes[std::size_t(n)].rest; });
        for (int n = 0; n < cell.node_count; ++n)
            parts.nodes[std::size_t(cell.nodes[std::size_t(n)])].mass +=
                density * volume / cell.node_count;
    }
}

}  // namespace pliant
