// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Transfer between a lattice and one with half the cells along some axes: displacements are
// interpolated, forces are restricted by the transpose.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/mesh.h>

#include "fem/held_nodes.h"
#include "fem/node_vector.h"

namespace pliant {

/// Node i of the coarse lattice is node factor · i of the fine one, or lies beyond its end.
struct LatticePair {
    HexLattice fine, coarse;
    Vec3i factor{2, 2, 2};  ///< each 1 or 2
    /// First planes of both lattices if they are slabs of larger ones. Coarse planes beside those
    /// that a slab owns receive incomplete forces.
    int fine_low = 0, coarse_low = 0;
};

/// Axes to halve, or {1, 1, 1} if coarsening would not help.
Vec3i coarsening_factor(const HexLattice& lattice);
LatticePair coarsened(const HexLattice& lattice, Vec3i factor);

/// Means of the fine cells' values; cells beyond the end count as 0. @param fine  [cell]
std::vector<double> coarse_means(const LatticePair& pair, std::span<const double> fine);
/// Holds each coarse node that would move a held fine node.
HeldNodes coarse_held(const LatticePair& pair, const HeldNodes& fine);

/// coarse = Pᵀ fine
void gather_forces(const LatticePair& pair, const NodeVector& fine, NodeVector& coarse,
                   const TaskArena& arena);
/// fine += P coarse
void add_interpolated(const LatticePair& pair, const NodeVector& coarse, NodeVector& fine,
                      const TaskArena& arena);

}  // namespace pliant
