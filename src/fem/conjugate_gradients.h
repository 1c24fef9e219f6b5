// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Conjugate gradients [Hestenes1952], preconditioned with the inverse of each node's own 3 × 3
// block. Sums are taken over fixed pieces and then in order, so that they don't depend on threads.

#pragma once

#include <pliant/tasks.h>

#include <vector>

#include "fem/held_nodes.h"
#include "fem/stiffness.h"

namespace pliant {

/// Inverses of the free part of the diagonal blocks; zero where held.
class BlockJacobi {
  public:
    BlockJacobi(const Stiffness& stiffness, const HeldNodes& held, const TaskArena& arena);
    std::int64_t bytes() const { return std::int64_t(m_values.size() * sizeof(double)); }

    /// The six numbers xx, yy, zz, yz, zx, xy of all nodes.
    const double* entry(int n) const { return m_values.data() + std::size_t(n) * m_count; }

  private:
    std::size_t m_count;
    std::vector<double> m_values;
};

struct Convergence {
    int iterations = 0;
    bool reached = false;
    double residual = 0;  ///< 2-norm, as the recurrence has it
};

/// Solves K u = f for what is free, from u = 0.
/// @param force  zero where held
/// @param[out] displacement  zero where held
/// @param residual  the iterations end where the 2-norm of f − K u is that small
Convergence conjugate_gradients(const Stiffness& stiffness, const BlockJacobi& preconditioner,
                                const HeldNodes& held, const NodeVector& force, double residual,
                                int max_iterations, const TaskArena& arena,
                                NodeVector& displacement);

/// The same sum for any number of threads.
double ordered_dot(const NodeVector& a, const NodeVector& b, const TaskArena& arena);

}  // namespace pliant
