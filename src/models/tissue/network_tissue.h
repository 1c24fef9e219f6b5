// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A mass-spring network with nodes of its own as a tissue. A sweep is a step of implicit Euler.
// Spheres and eyes touch the boundary triangles of the tetrahedra (springs/touch.h).

#pragma once

#include <pliant/tissues.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "springs/touch.h"
#include "tissue/spring_nodes.h"

namespace pliant {

class NetworkTissue final : public SpringNodes {
  public:
    static Result<std::unique_ptr<MeshTissue>> create(const Volume& scan, SpringParts parts,
                                                      const NetworkSettings& settings,
                                                      const TaskArena& arena);

    TissueTraits traits() const noexcept override;
    std::optional<Vec3d> force_n(std::uint32_t tool) noexcept override;
    /// "network_nodes", "links", "tetrahedra" and "fixed_nodes".
    Record figures() const override;
    Record report() const override;
    std::uint64_t file_kind() const noexcept override { return 0x35'6e'73'6c'70'00'00'0a; }

  private:
    NetworkTissue(SpringTissue tissue, std::vector<std::array<std::int32_t, 4>> cells,
                  std::unique_ptr<MovingScan> carried);
    void hold_nodes() noexcept override;
    Status stride(std::span<const std::int32_t> nodes, Vec3d shift) override;
    Status step() override;
    bool can_begin(TouchTool& sphere) override;
    SlideStep slide_step(const TouchTool& sphere, const Push& way, int n, int count) const override;
    Result<LimitedBy> slide_by(std::uint32_t tool, TouchTool& sphere, Vec3d shift) override;
    double folded_cells(std::span<const Vec3d> positions_mm) override;
    bool has_spheres() const { return !m_spheres.empty() || !m_eyes.empty(); }
    void keep_spheres_clear(const TouchTool* moved = nullptr);
    bool is_far() const;

    TriangleTouch m_touch;                     ///< of the network's surface
    std::size_t m_pushed = 0;                  ///< nodes of m_tools are the first of m_held
    std::vector<std::int32_t> m_sphere_nodes;  ///< memory of hold_nodes
    std::vector<std::uint8_t> m_is_held;       ///< [node]; all 0 between calls
};

#pragma GCC visibility push(default)  // for other components
/// make_network (tissues.h), with nodes that can be read.
Result<std::unique_ptr<MeshTissue>> make_network_tissue(const Volume& scan, SpringParts parts,
                                                        const NetworkSettings& settings,
                                                        const TaskArena& arena);
#pragma GCC visibility pop

}  // namespace pliant
