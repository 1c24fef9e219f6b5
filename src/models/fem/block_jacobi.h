// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inverse D⁻¹ of the 3 × 3 diagonal blocks of a stiffness matrix: a preconditioner, and the
// basis of smoothers.

#pragma once

#include <array>
#include <vector>

#include "fem/held_nodes.h"
#include "fem/stiffness.h"

namespace pliant {

/// xx, yy, zz, yz, zx, xy.
using SymmetricBlock = std::array<double, 6>;

/// Inverse of the free part of a symmetric positive block; zero in held components.
SymmetricBlock free_inverse(const Block3& block, std::uint8_t held);

inline Vec3d multiply(const SymmetricBlock& m, Vec3d v) {
    return {m[0] * v.x + m[5] * v.y + m[4] * v.z, m[5] * v.x + m[1] * v.y + m[3] * v.z,
            m[4] * v.x + m[3] * v.y + m[2] * v.z};
}

class BlockJacobi {
  public:
    /// @param held   of some nodes in order
    /// @param first  the first of them
    BlockJacobi(const Stiffness& stiffness, const HeldNodes& held, const TaskArena& arena,
                std::int64_t first = 0);
    /// The same stiffness with other held components: renews the nodes that differ.
    /// @param old_held  of the other
    BlockJacobi(const BlockJacobi& other, const HeldNodes& old_held, const Stiffness& stiffness,
                const HeldNodes& held);
    std::int64_t bytes() const { return std::int64_t(m_values.size() * sizeof(double)); }

    /// Computes to = factor · D⁻¹ from + keep · to; zero in held components.
    void renew(const NodeVector& from, double factor, double keep, NodeVector& to,
               const TaskArena& arena) const;

  private:
    void set_block(std::size_t node, const Block3& block, std::uint8_t held);
    const double* entry(int n) const { return m_values.data() + std::size_t(n) * m_count; }

    std::size_t m_count;
    std::vector<double> m_values;  ///< structure of arrays: one of the six numbers for all nodes,
                                   ///< then the next
};

}  // namespace pliant
