// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A geometric multigrid cycle for lattices, as preconditioner of conjugate gradients [Briggs2000].
// Each level smooths the high frequencies of the error. The rest is smooth, and is solved on a
// lattice with half the cells along each axis, at an eighth of the cost.
//
//   level 0   o─o─o─o─o─o      smooth, residual ↓   ↑ add, smooth
//   level 1   o───o───o───o    smooth, residual ↓   ↑ add, smooth      (may extend beyond)
//   level 2   o───────o───────o    factor
//
// Coarse cells have the mean moduli of their eight cells (0 beyond the lattice), so only the last
// level has a matrix. An axis with a much larger spacing is not coarsened until the spacings are
// similar. The smoother is a Chebyshev polynomial over the nodes' blocks for the upper part of the
// spectrum. Its bound comes from single elements: λ(D⁻¹K) ≤ max λ(D_e⁻¹K_e) for every assembly of
// them, with or without held nodes.
//
// The cycle is symmetric and positive: restriction is the transpose of interpolation, and pre- and
// post-smoothing use the same polynomial.

#pragma once

#include <pliant/models/fem.h>

#include <memory>
#include <span>
#include <vector>

#include "fem/block_jacobi.h"
#include "fem/block_matrix.h"
#include "fem/cholesky.h"
#include "fem/held_nodes.h"
#include "fem/lattice_stiffness.h"

namespace pliant {

/// Upper bound of the spectrum of D⁻¹K for boxes of any of the materials.
double spectrum_bound(Vec3d spacing, std::span<const ElasticMaterial> materials);

class Multigrid {
  public:
    /// Keeps references to the first two.
    Multigrid(const LatticeStiffness& stiffness, const HeldNodes& held,
              std::span<const ElasticMaterial> materials, const TaskArena& arena);
    /// The same lattices with other held components; shares their stiffness. Keeps a reference to
    /// the latter.
    Multigrid(const Multigrid& other, const HeldNodes& held);

    ~Multigrid();

    /// Vectors of all levels; one object per solving thread.
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
    /// displacement ≈ K⁻¹ force. @param force  zero in held components, as the displacement will be
    void apply(const NodeVector& force, NodeVector& displacement, Work& work,
               const TaskArena& arena) const;

    std::int64_t bytes() const;

  private:
    struct Level;
    void assemble_last(const TaskArena& arena);
    void factor_last();
    void cycle(std::size_t level, Work& work, const TaskArena& arena) const;
    void smooth(std::size_t level, bool with_residual, Work::Level& work,
                const TaskArena& arena) const;

    std::vector<std::unique_ptr<Level>> m_levels;
    std::shared_ptr<const BlockMatrix> m_matrix;     ///< of the last level; null: it is large
    std::shared_ptr<const CholeskyFactor> m_factor;  ///< of the matrix; null: none, or singular
};

}  // namespace pliant
