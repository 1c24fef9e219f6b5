// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A vessel as a tissue: a catheter is driven, the wall deforms, and the scan moves with the wall. A
// sweep is two steps of the simulation. Simulated time stops once the motion has settled, until the
// next command. Undo reverts all motion since a hand began to drive: a step stores the state before
// it, in memory.

#pragma once

#include <pliant/catheter.h>
#include <pliant/scene_files.h>

#include <list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <pliant/own_tissue.h>
#include "protocol/commands.h"

namespace pliant::serve {

/// Display data of a vessel beside the scan.
struct VesselView {
    std::vector<Vec3d> catheter_mm;  ///< part inside of the vessel, from the guide to the tip
    std::vector<Vec3f> moved_mm;     ///< displacements of the ghost surface's nodes
    double wall_moved_mm = 0;        ///< largest displacement of a wall node
    std::int64_t inverted = 0;       ///< tetrahedra of wall and catheter
};

class VesselTissue final : public NodeTissue {
  public:
    static constexpr int kStepsPerSweep = 2;

    /// Keeps references to all three.
    static Result<std::unique_ptr<VesselTissue>> create(const MadeVessel& vessel,
                                                        const Volume& scan, const TaskArena& arena);

    /// Sets the hand's motion until the next command, or until its client lets go.
    Status drive(std::uint32_t client, const DriveCommand& command);

    TissueTraits traits() const noexcept override;
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept override;
    void release(std::uint32_t tool) noexcept override;
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return m_driver == tool && tool != 0;
    }
    bool is_touched() const noexcept override { return m_driver != 0; }
    Result<Sweep> sweep() noexcept override;
    Status reset() noexcept override;
    Status rest() noexcept override { return halt(); }

    void state(std::vector<double>& numbers) const override { numbers = m_scene->state(); }
    Status set_state(std::span<const double> numbers) noexcept override;
    std::uint64_t file_kind() const noexcept override { return 0x32'76'73'6c'70'00'00'0a; }
    std::uint64_t hash() const override { return m_scene->hash(); }

    const Volume& volume() const override { return m_carried.scan().volume(); }
    const Deformation& deformation() const override;
    const TaskArena& arena() const override { return m_arena; }
    Status update_deformation() const override;

    const MadeVessel& made() const { return m_vessel; }
    const CatheterCommand& hand() const { return m_hand; }
    CatheterMeasures measures() const { return m_scene->quick_measures(); }
    const VesselView& view() const;
    /// Reason of a permanent stop, until a reset; empty: none.
    const std::string& failure() const { return m_failure; }

  private:
    VesselTissue(const MadeVessel& vessel, CatheterScene scene, CarriedScan carried,
                 const TaskArena& arena);
    Status show() const;
    bool is_calm() noexcept;
    Status halt() noexcept;

    const MadeVessel& m_vessel;
    const TaskArena& m_arena;
    std::unique_ptr<CatheterScene> m_scene;
    CatheterCommand m_hand{};
    std::uint32_t m_driver = 0;         ///< client whose hand moves; 0: none
    int m_untold = 0;                   ///< sweeps since the last command
    std::vector<Vec3d> m_wire, m_wall;  ///< at the last call of is_calm()
    std::string m_failure;

    // Display data are computed on demand, not in each step.
    mutable CarriedScan m_carried;
    mutable TetMesh m_now;
    mutable VesselView m_view;
    mutable bool m_is_shown = false;
};

}  // namespace pliant::serve
