// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The stiffness matrix of the present shape, without ever being put together, and conjugate
// gradients on it.
//
//   link along n:   k n nᵀ + k·max(0, 1 − l/|r|)·(I − n nᵀ)      [Baraff1998]
//   cell:           bulk/V₀ · (g gᵀ + (V − V₀) ∂g/∂x),  g = ∂V/∂x
//
// Where the matrix must stay positive (TangentKind::Positive), what a compressed link takes away
// across itself and what a cell adds by the change of g are left out.

#pragma once

#include "springs/state.h"

namespace pliant {

struct SolveLimits {
    double tolerance;  ///< of the residual, relative to the right side
    std::int32_t iterations;
};

enum class TangentKind { Positive, Exact };

class Tangent {
  public:
    /// Of the state's shape; the matrix solved is  inertia·M + drag·D + links·C + K, with M the
    /// masses, D the nodes' damping and C the links'.
    /// @param moves  [node]: the unknowns; others keep their value in solve()
    void renew(const SpringNetwork& network, const SpringState& state,
               std::span<const std::uint8_t> moves, TangentKind kind, double inertia, double drag,
               double links);
    /// out = K·v alone where whole is false.
    void multiply(const SpringNetwork& network, std::span<const Vec3d> v, bool whole,
                  std::span<Vec3d> out) const;
    /// Conjugate gradients, preconditioned with the blocks of the diagonal. @param[in,out] v  start
    /// and solution; stays as it is where nodes don't move
    /// @returns iterations; above the limit where the tolerance wasn't reached, or where the matrix
    /// turns out not to be positive: v is then as good as it got
    std::int32_t solve(const SpringNetwork& network, std::span<const Vec3d> right,
                       const SolveLimits& limits, std::vector<Vec3d>& v);
    /// The same from v = 0, to go downhill in energy with: where the matrix isn't positive, or a
    /// node would go farther than the radius, v ends at the radius [Steihaug1983].
    /// @returns what the energy loses by it if the matrix tells the truth
    double descend(const SpringNetwork& network, std::span<const Vec3d> force,
                   const SolveLimits& limits, double radius, std::vector<Vec3d>& v);

  private:
    struct Link {
        Vec3d n;
        double along, across;  ///< k − across, and across
        double damping;
    };
    void multiply_unknowns(const SpringNetwork& network, std::span<const Vec3d> v);
    void precondition();
    /// One iteration of conjugate gradients. @param weight  of the residual, before and after
    void go_on(std::vector<Vec3d>& v, double step, double& weight);
    void multiply_cells(const SpringNetwork& network, std::span<const Vec3d> v,
                        std::span<Vec3d> out) const;
    Vec3d product(const SpringNetwork& network, std::span<const Vec3d> v, std::int32_t node,
                  bool whole) const;

    std::vector<Link> m_links;
    std::vector<Vec3d> m_gradient;   ///< [8 · cell + corner]
    std::vector<double> m_cell;      ///< bulk/V₀; 0: none
    std::vector<double> m_pressure;  ///< [cell]: bulk (V − V₀)/V₀; empty unless Exact
    std::vector<Vec3d> m_place;      ///< [node]; likewise
    std::vector<double> m_diagonal;  ///< inertia·m + drag·d
    std::vector<Mat3d> m_precondition;
    std::vector<std::uint8_t> m_moves;
    std::vector<Vec3d> m_residual, m_direction, m_image, m_scaled;
};

}  // namespace pliant
