// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A coarse space of rigid motions as a part of a preconditioner [Nicolaides1987].
//
// The free nodes are divided into compact groups. Each can translate and rotate as a whole: six
// unknowns. With Z the motions of the nodes for these unknowns, and A the matrix of the network at
// rest, the correction is  Z (Zᵀ A Z)⁻¹ Zᵀ r. It removes the long waves of the error, which take
// most iterations otherwise.
//
// A of the shape at rest serves every shape and every set of held nodes: iterations are the same to
// a few percent, and a step's result depends on the state alone, not on earlier steps.

#pragma once

#include <pliant/models/springs.h>

#include "base/aligned_array.h"
#include "springs/block_product.h"

namespace pliant {

class CoarseSpace {
  public:
    /// @param at_rest  moves: all nodes that aren't fixed
    void prepare(const SpringNetwork& network, const BlockMatrix& at_rest);
    /// Starts a sum over nodes, Zᵀ r.
    void begin();
    void add(std::size_t node, const double* residual) {
        const std::int32_t group = m_group[node];
        if (group < 0) return;
        const double* const d = m_arm.data() + 4 * node;
        double* const to = m_right.data() + 6 * std::size_t(group);
        for (int c = 0; c < 3; ++c) to[c] += residual[c];
        to[3] += d[1] * residual[2] - d[2] * residual[1];
        to[4] += d[2] * residual[0] - d[0] * residual[2];
        to[5] += d[0] * residual[1] - d[1] * residual[0];
    }
    /// Solves for the unknowns.
    void solve();
    /// Adds the motion of a node to z.
    void correct(std::size_t node, double* z) const {
        const std::int32_t group = m_group[node];
        if (group < 0) return;
        const double* const d = m_arm.data() + 4 * node;
        const double* const u = m_motion.data() + 6 * std::size_t(group);
        z[0] += u[0] + (u[4] * d[2] - u[5] * d[1]);
        z[1] += u[1] + (u[5] * d[0] - u[3] * d[2]);
        z[2] += u[2] + (u[3] * d[1] - u[4] * d[0]);
    }

  private:
    void divide(const SpringNetwork& network);

    std::vector<std::int32_t> m_group;  ///< [node]; −1: fixed
    AlignedArray m_arm;                 ///< [4 · node] from the group's centre
    std::size_t m_group_count = 0, m_size = 0;
    AlignedVector<float> m_inverse;  ///< panels of kPanel rows, by columns
    AlignedArray m_right, m_motion;  ///< [6 · group]
};

}  // namespace pliant
