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
// Ranks have slabs of the fine levels (slabs.h). Levels whose slabs would be thin are solved by all
// ranks alike.
//
// The cycle is symmetric and positive: restriction is the transpose of interpolation, and pre- and
// post-smoothing use the same polynomial.

#pragma once

#include <pliant/models/fem.h>

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fem/block_jacobi.h"
#include "fem/cholesky.h"
#include "fem/lattice_stiffness.h"
#include "fem/slabs.h"

namespace pliant {

class Multigrid {
  public:
    /// Keeps references to the first two.
    Multigrid(const LatticeStiffness& stiffness, const HeldNodes& held,
              std::span<const ElasticMaterial> materials, const TaskArena& arena);

    /// A lattice, or a rank's slab of it.
    struct Parts {
        const LatticeStiffness& whole;  ///< its moduli are averaged for the coarse levels
        const HeldNodes& whole_held;
        const Slabs& slabs;
        const LatticeStiffness& stiffness;  ///< of the slab
        const HeldNodes& held;
    };
    /// Keeps references to the last three. Every rank makes one, and all call apply() together.
    Multigrid(const Parts& parts, std::span<const ElasticMaterial> materials,
              const TaskArena& arena);
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
        std::unique_ptr<NodeVector> m_slab_force;  ///< for the rest
        std::unique_ptr<Work> m_rest;
    };
    /// displacement ≈ K⁻¹ force. @param force  zero in held components, as the displacement will be
    void apply(const NodeVector& force, NodeVector& displacement, Work& work,
               const TaskArena& arena) const;

    std::int64_t bytes() const;

  private:
    struct Level;
    struct Rest;
    void factor_last(const TaskArena& arena);
    void cycle(std::size_t level, Work& work, const TaskArena& arena) const;
    void smooth(std::size_t level, bool with_residual, Work::Level& work,
                const TaskArena& arena) const;

    /// Adds the correction of the levels below the last one that has slabs. @param[out] step
    void solve_rest(const NodeVector& residual, NodeVector& step, Work& work,
                    const TaskArena& arena) const;

    std::vector<std::unique_ptr<Level>> m_levels;
    std::unique_ptr<Rest> m_rest;            ///< levels without slabs, below those with slabs
    std::optional<CholeskyFactor> m_factor;  ///< factor of the last level
};

}  // namespace pliant
