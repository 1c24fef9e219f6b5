// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Matrix-free tangent stiffness of the present shape, and conjugate gradients on it.
//
//   link along n:   k n nᵀ + k·max(0, 1 − l/|r|)·(I − n nᵀ)      [Baraff1998]
//   cell:           bulk/V₀ · (g gᵀ + (V − V₀) ∂g/∂x),  g = ∂V/∂x
//
// If the matrix must stay positive (TangentKind::Positive), the negative transverse term of a
// compressed link and the ∂g/∂x term of a cell are left out.

#pragma once

#include "springs/state.h"

namespace pliant {

struct SolveLimits {
    double tolerance;  ///< of the residual, relative to the right side
    std::int32_t iterations;
    const std::function<bool()>* give_up = nullptr;  ///< ends descend()
};

enum class TangentKind { Positive, Exact };

class Tangent {
  public:
    /// Sets up the matrix  inertia·M + drag·D + links·C + K  for the state's shape, with M the
    /// masses, D the nodes' damping and C the links'.
    /// @param moves  [node]: the unknowns; others keep their value in solve()
    void renew(const SpringNetwork& network, const SpringState& state,
               std::span<const std::uint8_t> moves, TangentKind kind, double inertia, double drag,
               double links);
    /// Computes out = K·v only, if `whole` is false.
    void multiply(const SpringNetwork& network, std::span<const Vec3d> v, bool whole,
                  std::span<Vec3d> out) const;
    /// Conjugate gradients with a block Jacobi preconditioner. @param[in,out] v  start and
    /// solution; unchanged at fixed nodes
    /// @returns iterations; above the limit if the tolerance wasn't reached or the matrix isn't
    ///          positive: v is then the best approximation
    std::int32_t solve(const SpringNetwork& network, std::span<const Vec3d> right,
                       const SolveLimits& limits, std::vector<Vec3d>& v);
    /// Truncated conjugate gradients from v = 0 for energy minimisation. If the matrix isn't
    /// positive, or a node would exceed the trust radius, v ends at the radius [Steihaug1983].
    /// @returns the energy decrease predicted by the matrix
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
    std::vector<Vec3d> m_position;   ///< [node]; empty unless Exact
    std::vector<double> m_diagonal;  ///< inertia·m + drag·d
    std::vector<Mat3d> m_precondition;
    std::vector<std::uint8_t> m_moves;
    std::vector<Vec3d> m_residual, m_direction, m_image, m_scaled;
};

}  // namespace pliant
