// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A mass-spring network with nodes of its own as a tissue. A sweep is a step of implicit Euler.
// States are positions at rest: a restored network starts without velocity.

#pragma once

#include <pliant/tissues.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "resample/embedded_scan.h"

namespace pliant {

class NetworkTissue final : public NodeTissue {
  public:
    static Result<std::unique_ptr<Tissue>> create(const Volume& scan, SpringParts parts,
                                                  const NetworkSettings& settings,
                                                  const TaskArena& arena);

    TissueTraits traits() const noexcept override;
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept override;
    void release(std::uint32_t tool) noexcept override;
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return m_tools.contains(tool);
    }
    bool is_touched() const noexcept override { return !m_tools.empty(); }
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

    const Volume& volume() const override { return m_carried->volume(); }
    const Deformation& deformation() const override;
    const TaskArena& arena() const override { return m_carried->arena(); }
    Status update_deformation() const override;

  private:
    using Tools = std::map<std::uint32_t, std::vector<std::int32_t>>;

    NetworkTissue(SpringTissue tissue, std::vector<std::array<std::int32_t, 4>> cells,
                  std::unique_ptr<EmbeddedScan> carried);
    Result<PushReport> push_nodes(std::uint32_t tool, const Push& push);
    std::vector<std::int32_t> nodes_at(const Push& push, Vec3d point_mm, bool or_around) const;
    Tools with(std::uint32_t tool, std::vector<std::int32_t> nodes) const;
    void hold_all() noexcept;
    Status stride(std::uint32_t tool, Vec3d shift);
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
    Tools m_tools;                                     ///< nodes that each tool holds, sorted
    std::vector<std::int32_t> m_held;                  ///< by all tools
    bool m_settled = true;
    std::vector<Vec3d> m_positions, m_held_positions;  ///< memory of noexcept functions
    mutable std::vector<Vec3d> m_shown;                ///< [node], of the deformation
    mutable bool m_is_shown = true;
};

}  // namespace pliant
