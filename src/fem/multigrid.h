// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A geometric multigrid cycle for lattices, as preconditioner of conjugate gradients
// [Briggs2000]. What neighbours disagree on is smoothed out on each level; what is left is smooth,
// and is solved for on a lattice with half the cells along each axis, where it costs an eighth.
//
//   level 0   o─o─o─o─o─o      smooth, residual ↓   ↑ add, smooth
//   level 1   o───o───o───o    smooth, residual ↓   ↑ add, smooth      (may stand out beyond)
//   level 2   o───────o───────o    factor
//
// Coarse cells have the mean of their eight cells' moduli (where the lattice ends, of nothing), so
// no level has a matrix but the last. An axis whose spacing is much larger than another's is left
// as it is until they are alike. The smoother is Chebyshev's polynomial over the blocks of the
// nodes, for the upper part of the spectrum. Its bound comes from the single elements:
// λ(D⁻¹K) ≤ max λ(D_e⁻¹K_e) for whatever is assembled of them, held nodes or not.
//
// The cycle is symmetric and positive: restriction is the transpose of interpolation, and the same
// polynomial is used before and after.

#pragma once

#include <pliant/fem.h>

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fem/block_jacobi.h"
#include "fem/cholesky.h"
#include "fem/lattice_stiffness.h"

namespace pliant {

class Multigrid {
  public:
    /// Keeps references to the first two.
    Multigrid(const LatticeStiffness& stiffness, const HeldNodes& held,
              std::span<const ElasticMaterial> materials, const TaskArena& arena);
    ~Multigrid();

    /// The vectors of all levels; one for each thread that solves.
    class Work {
      public:
        explicit Work(const Multigrid& multigrid);

      private:
        friend class Multigrid;
        struct Level {
            NodeVector force, displacement, residual, step, product;
        };
        std::vector<Level> m_levels;
    };
    /// displacement ≈ K⁻¹ force. @param force  zero where held, as the displacement will be
    void apply(const NodeVector& force, NodeVector& displacement, Work& work,
               const TaskArena& arena) const;

    std::int64_t bytes() const;

  private:
    struct Level;
    void factor_last(const TaskArena& arena);
    void cycle(std::size_t level, Work& work, const TaskArena& arena) const;
    void smooth(std::size_t level, bool with_residual, Work::Level& work,
                const TaskArena& arena) const;

    std::vector<std::unique_ptr<Level>> m_levels;
    std::optional<CholeskyFactor> m_factor;  ///< of the last level
};

}  // namespace pliant
