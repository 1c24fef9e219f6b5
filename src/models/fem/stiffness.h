// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Linear operator of a solid's stiffness matrix K: stored as blocks (meshes) or matrix-free
// (lattices).

#pragma once

#include <pliant/core/tasks.h>

#include <array>
#include <cstdint>

#include "fem/node_vector.h"

namespace pliant {

/// 3 × 3, row-major.
using Block3 = std::array<double, 9>;

class Stiffness {
  public:
    virtual ~Stiffness() = default;
    /// force = K displacement; equal bits for any number of threads.
    virtual void multiply(const NodeVector& displacement, NodeVector& force,
                          const TaskArena& arena) const = 0;
    virtual Block3 diagonal_block(std::int32_t node) const = 0;
    virtual std::int64_t bytes() const = 0;
};

}  // namespace pliant
