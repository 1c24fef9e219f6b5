// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Preconditioned conjugate gradients [Hestenes1952]. Sums are taken over fixed pieces in a fixed
// order, so that they are independent of threads.

#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "fem/held_nodes.h"
#include "fem/stiffness.h"

namespace pliant {

struct Convergence {
    int iterations = 0;
    bool reached = false;
    double residual = 0;  ///< 2-norm from the recurrence
};

/// z = M⁻¹ r, symmetric and positive on the free components, zero in held ones.
using Preconditioner = std::function<void(const NodeVector& r, NodeVector& z)>;

/// Nodes per partial sum.
inline constexpr std::int64_t kSumPiece = 2048;
/// The sum over a piece, begin ≤ node < end.
double dot_of_piece(const NodeVector& a, const NodeVector& b, std::int64_t begin, std::int64_t end);

/// The sums of conjugate gradients, over fixed pieces.
class Sums {
  public:
    virtual ~Sums() = default;
    virtual double dot(const NodeVector& a, const NodeVector& b) const = 0;
    /// u += step · p, r −= step · q. @returns r · r
    virtual double advance(double step, const NodeVector& p, const NodeVector& q, NodeVector& u,
                           NodeVector& r) const = 0;
};

/// Sums over whole vectors.
class WholeSums : public Sums {
  public:
    explicit WholeSums(const TaskArena& arena) : m_arena(arena) {}
    double dot(const NodeVector& a, const NodeVector& b) const override;
    double advance(double step, const NodeVector& p, const NodeVector& q, NodeVector& u,
                   NodeVector& r) const override;

  private:
    const TaskArena& m_arena;
    mutable std::vector<double> m_sums;
};

/// Solves K u = f on the free components, from u = 0.
/// @param force  zero in held components
/// @param residual  stops when the 2-norm of f − K u is below this
/// @param[out] displacement  zero in held components
Convergence conjugate_gradients(const Stiffness& stiffness, const Preconditioner& precondition,
                                const HeldNodes& held, const NodeVector& force, double residual,
                                int max_iterations, const Sums& sums, const TaskArena& arena,
                                NodeVector& displacement);

/// Dot product, equal for any number of threads.
double ordered_dot(const NodeVector& a, const NodeVector& b, const TaskArena& arena);

}  // namespace pliant
