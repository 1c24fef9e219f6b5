// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A position-based body as a tissue. A sweep is a time step of the body.
//
// A control lattice carries the scan (embedded_lattice.h).

#pragma once

#include <pliant/mesh.h>
#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tissue/embedded_lattice.h"

namespace pliant {

class BodyTissue final : public NodeTissue {
  public:
    static Result<std::unique_ptr<Tissue>> create(const Volume& scan, PbdBody body,
                                                  const BodySettings& settings,
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
    /// "particles", "tetrahedra", and "fixed_particles".
    Record figures() const override;
    Record report() const override;

    void state(std::vector<double>& numbers) const override;
    Status set_state(std::span<const double> numbers) noexcept override;
    std::uint64_t file_kind() const noexcept override { return 0x33'62'73'6c'70'00'00'0a; }
    std::uint64_t hash() const override;

    const Volume& volume() const override { return m_lattice->volume(); }
    const Deformation& deformation() const override;
    const TaskArena& arena() const override { return m_lattice->arena(); }
    Status update_deformation() const override;

  private:
    using Tools = std::map<std::uint32_t, std::vector<std::int32_t>>;
    BodyTissue(PbdBody body, std::unique_ptr<ControlLattice> lattice,
               std::vector<CarriedNode> carried);
    Result<PushReport> push_nodes(std::uint32_t tool, const Push& push);
    std::vector<std::int32_t> nodes_at(const Push& push, Vec3d point_mm, bool or_around) const;
    void take(std::uint32_t tool, std::vector<std::int32_t> nodes);
    void set_masses() noexcept;
    Status stride(std::uint32_t tool, Vec3d shift);
    bool folds() const;
    bool is_weightless() const { return m_body.settings().gravity == Vec3d{0, 0, 0}; }
    void put(std::span<const Vec3d> positions, std::span<const Vec3d> velocities) noexcept;
    void come_to_rest() noexcept;
    Status show() const;

    PbdBody m_body;
    std::unique_ptr<ControlLattice> m_lattice;
    std::vector<CarriedNode> m_carried;                ///< [control node]
    std::vector<std::array<std::int32_t, 4>> m_cells;  ///< tetrahedra of the body
    std::vector<double> m_rest_volumes;                ///< [tetrahedron] [mm³]
    double m_edge_mm = 0;                              ///< mean edge of the tetrahedra
    Tools m_tools;                                     ///< nodes that each tool holds, sorted
    bool m_settled = true;
    std::vector<Vec3d> m_positions, m_velocities;  ///< memory of noexcept functions
    mutable std::vector<Vec3d> m_moved;            ///< [control node], as shown
    mutable bool m_is_shown = true;
};

}  // namespace pliant
