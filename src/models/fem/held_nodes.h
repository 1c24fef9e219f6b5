// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Supports, checked: they name existing nodes, don't contradict each other, and leave no rigid
// motion to any piece.

#pragma once

#include <pliant/models/fem.h>

#include <span>
#include <vector>

#include "fem/node_vector.h"
#include "fem/solid_shape.h"

namespace pliant {

struct HeldNodes {
    std::vector<std::uint8_t> axes;     ///< [node], bit a: component a is held
    NodeVector displacement_mm;         ///< 0 in free components
    std::vector<std::int32_t> nodes{};  ///< nodes with held components

    bool holds(std::size_t node, int axis) const { return axes[node] >> axis & 1; }
    /// Sets held components to zero.
    void clear(NodeVector& v) const;
};

/// @returns InvalidArgument that names the support, or the piece that can still move
Result<HeldNodes> hold(const SolidShape& shape, std::span<const Support> supports);

}  // namespace pliant
