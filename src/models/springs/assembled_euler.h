// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Implicit Euler with an assembled matrix, for networks whose nodes all move. The equations are
// those of Tangent with TangentKind::Positive:
//
//   (M/h² + D/h + C/h + K) v = (F + f)/h + M v/h²
//
// Tangent computes the product link by link and cell by cell in double precision. Here each pair of
// nodes has one 3×3 block with its links and cells, in single precision (block_product.h), and
// conjugate gradients have a coarse space beside the blocks of the nodes (coarse_space.h). Forces
// are in double precision: rounding of the matrix changes no equilibrium.
//
// K and C don't resist translations, so a block on the diagonal is the negative sum of its row,
// plus M/h² + D/h.

#pragma once

#include "springs/block_product.h"
#include "springs/coarse_space.h"
#include "springs/state.h"
#include "springs/tangent.h"

namespace pliant {

class AssembledEuler {
  public:
    explicit AssembledEuler(bool vectors)
        : m_multiply(vectors ? vector_block_product() : plain_block_product()) {}

    /// Makes the pattern of the matrix and the coarse space, unless they exist; allocates all
    /// memory of a step.
    void prepare(const SpringNetwork& network, double time_step);
    /// Discards them after a cut.
    void forget() noexcept { m_is_ready = false; }
    /// One step. @param moves  [node] @returns as Tangent::solve
    std::int32_t step(const SpringNetwork& network, SpringState& state,
                      std::span<const std::uint8_t> moves, double time_step,
                      const SolveLimits& limits) noexcept;

  private:
    struct Pair {
        std::int32_t a, b;    ///< a < b
        std::int32_t ab, ba;  ///< blocks: row a, row b
    };
    void make_pattern(const SpringNetwork& network);
    std::int32_t pair_of(std::int32_t a, std::int32_t b) const;
    /// Sets the matrix, and m_residual to the forces f of links and cells.
    void assemble(const SpringNetwork& network, double time_step) noexcept;
    void add_links(const SpringNetwork& network, double time_step) noexcept;
    void add_cells(const SpringNetwork& network) noexcept;
    double find_gradients(const SpringCell& cell, Vec3d (&gradients)[8]) const noexcept;
    void fill_diagonal(const SpringNetwork& network, double time_step) noexcept;
    std::int32_t solve(const SolveLimits& limits, double scale) noexcept;
    double reduce(double step) noexcept;
    double precondition() noexcept;

    BlockProduct m_multiply;
    bool m_is_ready = false;
    BlockMatrix m_matrix;
    std::vector<Pair> m_pairs;
    std::vector<std::int32_t> m_first_pair;   ///< [node a], and the total
    std::vector<std::int32_t> m_link_blocks;  ///< [link] of row min(a, b); −1: cut
    std::vector<std::int32_t> m_cell_blocks;  ///< of each cell, its pairs of corners
    std::vector<double> m_rest_volumes;       ///< [cell]; 0: without volume energy, or cut
    CoarseSpace m_coarse;
    AlignedArray m_position;         ///< [4 · node] x, y, z, 0, as all below
    AlignedVector<float> m_inverse;  ///< [12 · node] of the blocks on the diagonal
    AlignedArray m_velocity, m_residual, m_direction, m_image, m_scaled;
};

}  // namespace pliant
