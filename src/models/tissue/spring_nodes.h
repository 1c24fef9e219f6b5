// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissues whose nodes are those of a SpringTissue: networks, and the control nodes of a scan. A
// restored tissue has no velocity.

#pragma once

#include <pliant/models/mesh_tissue.h>
#include <pliant/models/springs.h>

#include "springs/rollback.h"

namespace pliant {

class SpringNodes : public MeshTissue {
  public:
    void positions_mm(std::span<Vec3d> positions_mm) const override {
        for (std::size_t n = 0; n < positions_mm.size(); ++n)
            positions_mm[n] = m_tissue.position(std::int32_t(n));
    }
    /// Force of links and volumes on the held nodes.
    std::optional<Vec3d> force_n(std::uint32_t tool) noexcept override;
    std::uint64_t hash() const override { return m_tissue.hash(); }

  protected:
    /// @param cells  tetrahedra of the nodes, if they are the network's cells
    SpringNodes(SpringTissue tissue, std::unique_ptr<MovingScan> carried,
                std::vector<std::array<std::int32_t, 4>> cells = {});
    const RestMesh& at_rest() const override { return m_rest; }
    bool is_fixed(std::int32_t n) const override {
        return m_tissue.network().nodes()[std::size_t(n)].fixed;
    }
    void put(std::span<const Vec3d> positions, std::span<const Vec3d> velocities) noexcept override;
    void keep() override { m_rollback.keep(m_tissue); }
    void take_back() noexcept override { m_rollback.restore(m_tissue); }
    Status stride(std::span<const std::int32_t> nodes, Vec3d shift) override;
    bool is_calm() override;
    std::int32_t fixed_nodes() const;
    /// Force on nodes, with the others held [N].
    std::optional<Vec3d> force_on(std::span<const std::int32_t> nodes) noexcept;
    /// Moves some of the held nodes.
    void move_held(std::span<const std::int32_t> nodes, Vec3d shift) noexcept;

    SpringTissue m_tissue;
    RestMesh m_rest;
    std::vector<std::int32_t> m_held;     ///< by all tools, in the tissue's order
    std::vector<Vec3d> m_held_positions;  ///< memory of noexcept functions

  private:
    SpringRollback m_rollback;
};

}  // namespace pliant
