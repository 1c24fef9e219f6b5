// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inverse D⁻¹ of each node's own 3 × 3 block of a stiffness matrix: a preconditioner, and what
// smoothers are made of.

#pragma once

#include <array>
#include <vector>

#include "fem/held_nodes.h"
#include "fem/stiffness.h"

namespace pliant {

/// xx, yy, zz, yz, zx, xy.
using SymmetricBlock = std::array<double, 6>;

/// The inverse of the free part of a symmetric positive block; zero where held.
SymmetricBlock free_inverse(const Block3& block, std::uint8_t held);

inline Vec3d multiply(const SymmetricBlock& m, Vec3d v) {
    return {m[0] * v.x + m[5] * v.y + m[4] * v.z, m[5] * v.x + m[1] * v.y + m[3] * v.z,
            m[4] * v.x + m[3] * v.y + m[2] * v.z};
}

class BlockJacobi {
  public:
    BlockJacobi(const Stiffness& stiffness, const HeldNodes& held, const TaskArena& arena);
    std::int64_t bytes() const { return std::int64_t(m_values.size() * sizeof(double)); }

    /// to = factor · D⁻¹ from + keep · to; zero where held.
    void renew(const NodeVector& from, double factor, double keep, NodeVector& to,
               const TaskArena& arena) const;

  private:
    const double* entry(int n) const { return m_values.data() + std::size_t(n) * m_count; }

    std::size_t m_count;
    std::vector<double> m_values;  ///< one of the six numbers of all nodes, then the next
};

}  // namespace pliant
