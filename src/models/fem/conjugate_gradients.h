// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Preconditioned conjugate gradients [Hestenes1952]. Sums are taken over fixed pieces in a fixed
// order, so that they are independent of threads.

#pragma once

#include <functional>
#include <vector>

#include "fem/held_nodes.h"
#include "fem/slabs.h"
#include "fem/stiffness.h"

namespace pliant {

struct Convergence {
    int iterations = 0;
    bool reached = false;
    double residual = 0;  ///< 2-norm from the recurrence
};

/// z = M⁻¹ r, symmetric and positive on the free components, zero in held ones.
using Preconditioner = std::function<void(const NodeVector& r, NodeVector& z)>;

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

/// Sums over vectors of which each rank has a slab: same pieces, same order, so the same bits.
class SlabSums : public Sums {
  public:
    /// @pre !slabs.is_whole()
    SlabSums(const Slabs& slabs, const TaskArena& arena);
    double dot(const NodeVector& a, const NodeVector& b) const override;
    double advance(double step, const NodeVector& p, const NodeVector& q, NodeVector& u,
                   NodeVector& r) const override;

  private:
    const Slabs& m_slabs;
    const TaskArena& m_arena;
    std::vector<std::size_t> m_counts;  ///< pieces of each rank: those that begin in its planes
    std::int64_t m_begin, m_end;        ///< the slab's nodes in the whole lattice
    std::int64_t m_borrowed;            ///< nodes above the slab in its last piece
    std::int64_t m_lent;                ///< nodes of the slab in the last piece of the rank below
    mutable std::vector<double> m_sums, m_all, m_lending, m_tail;
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
