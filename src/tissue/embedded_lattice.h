// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The lattice that carries a scan with tetrahedra. The displacement of a control node is
//
//   fade(d) · Σ w u,   fade(d) = (1 − (d/reach)²)²
//
// with the barycentric weights w of the tetrahedron around the node at rest; for a node at a
// distance d outside of the mesh, those of a point in the nearest tetrahedron.

#pragma once

#include <pliant/mesh.h>
#include <pliant/resample.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace pliant {

/// Displacement of a control node: a weighted sum over the nodes of a tetrahedron.
struct CarriedNode {
    std::array<std::int32_t, 4> nodes{};
    std::array<double, 4> weights{};
};

struct EmbeddedLattice {
    std::unique_ptr<ControlLattice> lattice;
    std::vector<CarriedNode> carried;  ///< [control node]
};

/// @param cell_mm   edge of a control cell, rounded to whole voxels
/// @param reach_mm  distance from the mesh at which the scan rests
/// @returns InvalidArgument for a mesh beside the scan, LimitExceeded for too many control nodes
Result<EmbeddedLattice> embed_lattice(const Volume& scan, const TetMesh& mesh, double cell_mm,
                                      double reach_mm, const TaskArena& arena);

/// @param moved  displacement(node) of the mesh
template <class Displacement>
Vec3d carried_displacement(const CarriedNode& carried, const Displacement& moved) {
    Vec3d sum{0, 0, 0};
    for (std::size_t k = 0; k < 4; ++k)
        if (carried.weights[k] > 0) sum = sum + carried.weights[k] * moved(carried.nodes[k]);
    return sum;
}

}  // namespace pliant
