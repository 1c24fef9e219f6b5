// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What supports hold, checked: that they name nodes that exist, don't contradict each other, and
// leave no piece of the solid a rigid motion.

#pragma once

#include <pliant/fem.h>

#include <span>
#include <vector>

#include "fem/node_vector.h"
#include "fem/solid_shape.h"

namespace pliant {

struct HeldNodes {
    std::vector<std::uint8_t> axes;     ///< [node], bit a: component a is held
    NodeVector displacement_mm;         ///< where held, else 0
    std::vector<std::int32_t> nodes{};  ///< those with any

    bool holds(std::size_t node, int axis) const { return axes[node] >> axis & 1; }
    /// Sets what is held to zero.
    void clear(NodeVector& v) const;
};

/// @returns InvalidArgument that names the support, or the piece that can still move
Result<HeldNodes> hold(const SolidShape& shape, std::span<const Support> supports);

}  // namespace pliant
