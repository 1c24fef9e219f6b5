// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The stiffness matrix K of a whole solid, as something that can be multiplied with: kept as blocks
// (any mesh) or never formed (lattices).

#pragma once

#include <pliant/tasks.h>

#include <array>
#include <cstdint>

#include "fem/node_vector.h"

namespace pliant {

/// 3 × 3 by rows.
using Block3 = std::array<double, 9>;

class Stiffness {
  public:
    virtual ~Stiffness() = default;
    /// force = K displacement; the same bits for any number of threads.
    virtual void multiply(const NodeVector& displacement, NodeVector& force,
                          const TaskArena& arena) const = 0;
    virtual Block3 diagonal_block(std::int32_t node) const = 0;
    virtual std::int64_t bytes() const = 0;
};

}  // namespace pliant
