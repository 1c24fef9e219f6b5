// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Preconditioned conjugate gradients [Hestenes1952]. Sums are taken over fixed pieces in a fixed
// order, so that they are independent of threads.

#pragma once

#include <functional>

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

/// Solves K u = f on the free components, from u = 0.
/// @param force  zero in held components
/// @param residual  stops when the 2-norm of f − K u is below this
/// @param[out] displacement  zero in held components
Convergence conjugate_gradients(const Stiffness& stiffness, const Preconditioner& precondition,
                                const HeldNodes& held, const NodeVector& force, double residual,
                                int max_iterations, const TaskArena& arena,
                                NodeVector& displacement);

/// Dot product, equal for any number of threads.
double ordered_dot(const NodeVector& a, const NodeVector& b, const TaskArena& arena);

}  // namespace pliant
