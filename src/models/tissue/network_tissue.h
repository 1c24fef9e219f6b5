// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A mass-spring network with nodes of its own as a tissue. A sweep is a step of implicit Euler.
// States are positions at rest: a restored network starts without velocity. A tool that slides
// touches the boundary triangles of the tetrahedra (springs/touch.h).

#pragma once

#include <pliant/tissues.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "resample/embedded_scan.h"
#include "springs/touch.h"

namespace pliant {

class NetworkTissue final : public MeshTissue {
  public:
    static Result<std::unique_ptr<MeshTissue>> create(const Volume& scan, SpringParts parts,
                                                      const NetworkSettings& settings,
                                                      const TaskArena& arena);

    TissueTraits traits() const noexcept override;
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept override;
    Result<SlideReport> slide(std::uint32_t tool, const Push& way,
                              const TissueValues& values) noexcept override;
    void release(std::uint32_t tool) noexcept override;
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return m_tools.contains(tool) || m_spheres.contains(tool);
    }
    bool is_touched() const noexcept override { return !m_tools.empty() || !m_spheres.empty(); }
    std::optional<Vec3d> force_n(std::uint32_t tool) noexcept override;
    Result<Sweep> sweep() noexcept override;
    Status reset() noexcept override;
    /// "network_nodes", "links", "tetrahedra" and "fixed_nodes".
    Record figures() const override;
    Record report() const override;

    void state(std::vector<double>& numbers) const override;
    Status set_state(std::span<const double> numbers) noexcept override;
    std::uint64_t file_kind() const noexcept override { return 0x35'6e'73'6c'70'00'00'0a; }
    std::uint64_t hash() const override { return m_tissue.hash(); }

    void positions_mm(std::span<Vec3d> positions_mm) const override {
        for (std::size_t n = 0; n < positions_mm.size(); ++n)
            positions_mm[n] = m_tissue.position(std::int32_t(n));
    }
    std::int32_t node_count() const override { return m_tissue.network().node_count(); }

    const Volume& volume() const override { return m_carried->volume(); }
    const Deformation& deformation() const override;
    const TaskArena& arena() const override { return m_carried->arena(); }
    Status update_deformation() const override;

  private:
    using Tools = std::map<std::uint32_t, std::vector<std::int32_t>>;
    using Spheres = std::map<std::uint32_t, TouchTool>;

    NetworkTissue(SpringTissue tissue, std::vector<std::array<std::int32_t, 4>> cells,
                  std::unique_ptr<EmbeddedScan> carried);
    Result<PushReport> push_nodes(std::uint32_t tool, const Push& push);
    std::vector<std::int32_t> nodes_at(const Push& push, Vec3d point_mm, bool or_around) const;
    Tools with(std::uint32_t tool, std::vector<std::int32_t> nodes) const;
    void hold_all() noexcept;
    void put_touched() noexcept;
    void keep_spheres_clear();
    Status step();
    Status stride(std::uint32_t tool, Vec3d shift);
    Result<SlideReport> slide_sphere(std::uint32_t tool, const Push& way);
    Result<bool> slide_stride(TouchTool& sphere, Vec3d shift, SlideReport& report);
    bool is_free(const TouchTool& sphere, Vec3d way_mm) const;
    template <class Act>
    auto undone_on_error(const Act& act);
    bool is_fixed(std::int32_t n) const { return m_tissue.network().nodes()[std::size_t(n)].fixed; }
    bool folds() const;
    bool is_far() const;
    void put(std::span<const Vec3d> positions) noexcept;
    void come_to_rest() noexcept;
    Status show() const;

    SpringTissue m_tissue;
    std::vector<std::array<std::int32_t, 4>> m_cells;  ///< tetrahedra of the network
    std::vector<double> m_rest_volumes;                ///< [tetrahedron] [mm³]
    double m_edge_mm = 0;                              ///< mean edge of the tetrahedra
    std::unique_ptr<EmbeddedScan> m_carried;           ///< the scan
    TriangleTouch m_touch;                             ///< of the network's surface
    Tools m_tools;                                     ///< nodes that each tool holds, sorted
    Spheres m_spheres;                                 ///< tools that slide
    std::vector<std::int32_t> m_held;                  ///< by all tools
    std::size_t m_pushed = 0;                          ///< those of m_tools are the first of m_held
    std::vector<std::int32_t> m_sphere_nodes;          ///< memory of hold_all
    std::vector<std::uint8_t> m_is_held;               ///< [node]; all 0 between calls
    bool m_settled = true;
    std::vector<Vec3d> m_positions, m_held_positions;  ///< memory of noexcept functions
    mutable std::vector<Vec3d> m_shown;                ///< [node], of the deformation
    mutable bool m_is_shown = true;
};

#pragma GCC visibility push(default)  // for other components
/// make_network (tissues.h), with nodes that can be read.
Result<std::unique_ptr<MeshTissue>> make_network_tissue(const Volume& scan, SpringParts parts,
                                                        const NetworkSettings& settings,
                                                        const TaskArena& arena);
#pragma GCC visibility pop

}  // namespace pliant
