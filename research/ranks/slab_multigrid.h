// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The multigrid cycle of fem/multigrid.h on slabs, to the same bits. Levels whose slabs would be
// thin are solved by all ranks alike.

#pragma once

#include <memory>
#include <span>
#include <vector>

#include "fem/multigrid.h"
#include "fem/multigrid_transfer.h"
#include "ranks/slabs.h"

namespace pliant {

class SlabMultigrid {
  public:
    /// A rank's slab of a lattice.
    struct Parts {
        const LatticeStiffness& whole;  ///< its moduli are averaged for the coarse levels
        const HeldNodes& whole_held;
        const Slabs& slabs;
        const LatticeStiffness& stiffness;  ///< of the slab
        const HeldNodes& held;
    };
    /// Keeps references to the last three. Every rank makes one, and all call apply() together.
    SlabMultigrid(const Parts& parts, std::span<const ElasticMaterial> materials,
                  const TaskArena& arena);
    ~SlabMultigrid();

    /// displacement ≈ K⁻¹ force. @param force  zero in held components, as the displacement will be
    void apply(const NodeVector& force, NodeVector& displacement);

  private:
    struct Level;
    struct Rest;
    void smooth(Level& level, bool with_residual);
    void cycle(std::size_t level);
    void solve_rest(const NodeVector& residual, NodeVector& step);

    const TaskArena& m_arena;
    std::vector<std::unique_ptr<Level>> m_levels;
    std::unique_ptr<Rest> m_rest;  ///< levels without slabs
};

}  // namespace pliant
