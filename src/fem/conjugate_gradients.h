// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Conjugate gradients [Hestenes1952] with any preconditioner. Sums are taken over fixed pieces and
// then in order, so that they don't depend on threads.

#pragma once

#include <functional>

#include "fem/held_nodes.h"
#include "fem/stiffness.h"

namespace pliant {

struct Convergence {
    int iterations = 0;
    bool reached = false;
    double residual = 0;  ///< 2-norm, as the recurrence has it
};

/// z = M⁻¹ r, symmetric and positive on what is free, zero where held.
using Preconditioner = std::function<void(const NodeVector& r, NodeVector& z)>;

/// Solves K u = f for what is free, from u = 0.
/// @param force  zero where held
/// @param residual  the iterations end where the 2-norm of f − K u is that small
/// @param[out] displacement  zero where held
Convergence conjugate_gradients(const Stiffness& stiffness, const Preconditioner& precondition,
                                const HeldNodes& held, const NodeVector& force, double residual,
                                int max_iterations, const TaskArena& arena,
                                NodeVector& displacement);

/// The same sum for any number of threads.
double ordered_dot(const NodeVector& a, const NodeVector& b, const TaskArena& arena);

}  // namespace pliant
