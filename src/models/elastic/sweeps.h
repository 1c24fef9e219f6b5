// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Passes over a lattice of cells: the product with the stiffness, fused with the operation that
// takes the product, so that no product is written to memory and read again.
//
// A product goes plane by plane. The sums and differences of a plane of nodes along x and y are
// computed once, and used by the layers of cells below and above it; the forces of a layer on its
// upper plane wait in the same form until the next layer adds its own. A node's force is the same
// expression whichever planes are asked for, and dot products have 16 lanes in a fixed order: the
// results have the same bits for any number of threads and on each instruction set.

#pragma once

#include <pliant/volume.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "elastic/cell_factors.h"

namespace pliant {

/// Rows are padded to this many floats; longest vector.
inline constexpr int kSweepLanes = 16;

using NodeRows = std::array<float*, 3>;  ///< components x, y, z: [plane][row][node]

/// Rotation of the cells in a product.
enum class Turning {
    None,
    Kept,      ///< forces of a displacement: R K Rᵀ u
    Positions  ///< forces in a deformed state: R K (Rᵀ(X + u) − X)
};

/// Operation on the product q = K x of each row.
enum class SweepPass {
    Store,     ///< out = q
    Residual,  ///< out = −q, 0 at held nodes
    Subtract,  ///< residual −= q, 0 at held nodes
    Smooth,    ///< residual −= q;  out = alpha D residual + beta x;  sum += out
    Direction  ///< out = q;  dots[plane] = x·q
};

struct LatticeSweep {
    const CellFactors* factors = nullptr;
    Vec3i nodes{0, 0, 0};
    int stride = 0;  ///< floats in a row
    /// [cell], indexed as the cell's lowest node; 0 in cells beyond the last node of an axis.
    const float* mu = nullptr;
    float lambda_per_mu = 0, void_mu = 0;  ///< λ = lambda_per_mu · max(μ − void_mu, 0)
    std::array<const float*, 4> turns{};   ///< quaternions w, x, y, z, for Turning
    Turning turning = Turning::None;
    const std::uint8_t* turned = nullptr;  ///< [plane][row] whether a cell of the row is turned
    Box3i left_out{{0, 0, 0}, {0, 0, 0}};  ///< cells without forces
    SweepPass pass = SweepPass::Store;
    NodeRows x{};  ///< argument of the product
    /// D, inverse diagonal blocks: xx, xy, xz, yy, yz, zz. 0 where no residual counts: the first
    /// one is +0 at held nodes, and −0 at nodes that follow the coarser lattice.
    std::array<const float*, 6> block{};
    NodeRows residual{}, sum{}, out{};
    float alpha = 0, beta = 0;
    double* dots = nullptr;  ///< [plane]
};

/// Executes a pass on the planes begin … end − 1 of nodes.
/// @param workspace  aligned to a cache line
void sweep_planes(const LatticeSweep& sweep, int begin, int end, float* workspace);
void sweep_planes_plain(const LatticeSweep& sweep, int begin, int end, float* workspace);

// Operations without a product, on ranges of nodes: begin and end are multiples of kSweepLanes.

struct NodeSweep {
    std::size_t begin = 0, end = 0;
    std::array<const float*, 6> block{};
};
/// out = alpha D residual; sum = out
void begin_smoothing(const NodeSweep& nodes, float alpha, const NodeRows& residual,
                     const NodeRows& out, const NodeRows& sum);
/// direction = step + beta direction
void renew_direction(const NodeSweep& nodes, float beta, const NodeRows& step,
                     const NodeRows& direction);
/// u += alpha direction; residual −= alpha product at free nodes. @returns residual·residual
double advance_nodes(const NodeSweep& nodes, float alpha, const NodeRows& direction,
                     const NodeRows& product, const NodeRows& u, const NodeRows& residual);
double dot_nodes(const NodeSweep& nodes, const NodeRows& a, const NodeRows& b);

/// Rotations by cell.
struct CellRotations {
    std::array<float*, 4> turns{};   ///< quaternions w, x, y, z
    std::uint8_t* turned = nullptr;  ///< [plane][row]
};
/// Finds the rotations of the cells for the displacement x, by steps of [Mueller2016] from none.
/// They are functions of the displacement alone. Below half a degree they count as none.
void turn_planes(const LatticeSweep& sweep, const CellRotations& rotations, int steps, int begin,
                 int end);
void turn_planes_plain(const LatticeSweep& sweep, const CellRotations& rotations, int steps,
                       int begin, int end);

/// Size of the workspace of sweep_planes [floats].
inline std::size_t sweep_workspace(Vec3i nodes, int stride) {
    return std::size_t(stride) * (24 * std::size_t(nodes.y) + 16) + 13 * kSweepLanes;
}

}  // namespace pliant
