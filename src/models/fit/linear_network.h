// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Stiffness of a network at its rest shape, linear in the values p of its groups:
//
//   K(p) = K₀ + Σ p_g K_g,    link along n: k n nᵀ,    cell: bulk/V₀ · g gᵀ with g = ∂V/∂x
//
// All matrices share one pattern, ordered once; K(p) is a sum of arrays. From K u = F follows K
// ∂u/∂p_g = −K_g u, with the same factor as for u.
//
// Up to some 2000 nodes the factor is Eigen's, with minimum degree ordering. Beyond,
// dissected_cholesky.h is used, and the last factor is cached.

#pragma once

#include <pliant/models/fit.h>

namespace pliant {

class LinearNetwork {
  public:
    /// Networks with more free nodes are factored by nested dissection.
    static constexpr std::size_t kMaxSimpleNodes = 2000;

    /// @param held  [node]: fixed nodes
    LinearNetwork(const SpringParts& parts, std::span<const FitGroup> groups,
                  std::span<const std::uint8_t> held,
                  std::size_t most_simple_nodes = kMaxSimpleNodes);
    ~LinearNetwork();
    LinearNetwork(LinearNetwork&&) noexcept;
    LinearNetwork& operator=(LinearNetwork&&) noexcept;

    struct Factor;
    /// Returns null if there is a motion without a force.
    std::shared_ptr<const Factor> factor(std::span<const double> values) const;
    /// Likewise for K + diag(d). @param diagonal  [node]: d of its three unknowns
    std::shared_ptr<const Factor> factor(std::span<const double> values,
                                         std::span<const double> diagonal) const {
        return make_factor(values, diagonal);
    }
    /// Solves K u = F; 0 at held nodes.
    std::vector<Vec3d> solve(const Factor& factor, std::span<const Vec3d> force) const;
    /// Computes K_g u.
    std::vector<Vec3d> multiply(std::size_t group, std::span<const Vec3d> u) const;

  private:
    std::vector<int> minimum_degree(const SpringParts& parts) const;
    std::vector<int> dissect(const SpringParts& parts, std::span<const std::uint8_t> held);
    std::shared_ptr<const Factor> make_factor(std::span<const double> values,
                                              std::span<const double> diagonal) const;

    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
