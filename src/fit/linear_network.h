// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A network's stiffness at its rest shape, linear in the values p of its groups:
//
//   K(p) = K₀ + Σ p_g K_g,    link along n: k n nᵀ,    cell: bulk/V₀ · g gᵀ with g = ∂V/∂x
//
// All matrices have one pattern, ordered once; K(p) is a sum of arrays. From K u = F follows
// K ∂u/∂p_g = −K_g u, with the factor that u came from.
//
// Up to some 2000 nodes the factor is Eigen's, ordered by minimum degree; beyond, that of
// dissected_cholesky.h, and the last one is kept.

#pragma once

#include <pliant/fit.h>

namespace pliant {

class LinearNetwork {
  public:
    /// Networks of more free nodes than this are factored by nested dissection.
    static constexpr std::size_t kMostSimpleNodes = 2000;

    /// @param held  [node]: those that don't move
    LinearNetwork(const SpringParts& parts, std::span<const FitGroup> groups,
                  std::span<const std::uint8_t> held,
                  std::size_t most_simple_nodes = kMostSimpleNodes);
    ~LinearNetwork();
    LinearNetwork(LinearNetwork&&) noexcept;
    LinearNetwork& operator=(LinearNetwork&&) noexcept;

    struct Factor;
    /// None where something moves without a force.
    std::shared_ptr<const Factor> factor(std::span<const double> values) const;
    /// u from K u = F; 0 where held.
    std::vector<Vec3d> solve(const Factor& factor, std::span<const Vec3d> force) const;
    /// K_g u.
    std::vector<Vec3d> multiply(std::size_t group, std::span<const Vec3d> u) const;

  private:
    std::vector<int> minimum_degree(const SpringParts& parts) const;
    std::vector<int> dissect(const SpringParts& parts, std::span<const std::uint8_t> held);
    std::shared_ptr<const Factor> make_factor(std::span<const double> values) const;

    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
