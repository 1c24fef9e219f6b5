// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Springs as a tissue: the control nodes of a scan. A sweep is ten node updates, ten milliseconds
// at 1 kHz. Tools hold the nodes of control cells. Forces start at held nodes, and at released ones
// until they are at rest.

#pragma once

#include <pliant/tissues.h>

#include <memory>
#include <optional>
#include <vector>

#include "tissue/spring_nodes.h"

namespace pliant {

class SpringScanTissue final : public SpringNodes {
  public:
    static constexpr int kStepsPerSweep = 10;
    static constexpr double kRate_hz = 1000;  ///< node updates per second

    static Result<std::unique_ptr<SpringScanTissue>> create(
        const Volume& volume, const SpringDeformationSettings& settings, const TaskArena& arena);

    TissueTraits traits() const noexcept override;
    Result<CutReport> cut(const CutSurface& surface) noexcept override;
    Result<Sweep> sweep() noexcept override;
    /// Its steps are node updates.
    Result<AdvanceReport> advance(const Budget& budget) noexcept override;
    Status reset() noexcept override;
    /// The depth of the forces.
    Record settings() const override;
    Status configure(const Record& changes) noexcept override;
    Result<std::int32_t> take_depth(double threshold_mm, std::int32_t max_depth) noexcept override;
    /// "nodes" along i, j, k and "active_nodes", the nodes that forces reached in the last sweep,
    /// or at most in the last call of advance().
    Record figures() const override;
    Record report() const override;
    /// While tissue moves, control nodes may lag by a fiftieth of a millimetre.
    Result<bool> approach_deformation(std::int64_t max_elements) const override;

    /// Positions of all nodes, and the corners of all cuts.
    void state(std::vector<double>& numbers) const override;
    Status set_state(std::span<const double> numbers) noexcept override;
    std::uint64_t file_kind() const noexcept override { return 0x31'70'73'6c'70'00'00'0a; }
    std::uint64_t hash() const override;

    bool is_settled() const { return m_settled; }
    /// Finds the smallest depth at which one more layer moves no node by more than the threshold,
    /// at the equilibrium with the present tools [Choi2004, 3.1.3]. Nothing changes.
    /// @returns depth 0 if it is above max_depth; NotFound if no tool holds a node
    Result<DepthFound> find_depth(double threshold_mm, std::int32_t max_depth) const;
    Status set_depth(std::int32_t depth) noexcept;
    /// Displacement of every control node [mm, LPS], as shown last, like control().
    const std::vector<Vec3d>& displacements_mm() const { return m_displacements; }
    /// Sets the positions of all nodes, at zero speed. Tools let go; displaced nodes can move.
    /// @returns InvalidArgument, with nothing changed, like ControlLattice::place
    Status set_positions(std::span<const Vec3d> positions_mm);
    /// Likewise, with other cuts than the present ones.
    Status set_shape(std::span<const Vec3d> positions_mm, std::span<const CutTriangle> cuts_mm);
    ControlLattice& control() const { return static_cast<ControlLattice&>(*m_carried); }
    using SpringNodes::fixed_nodes;

  private:
    SpringScanTissue(const SpringDeformationSettings& settings, SpringTissue tissue,
                     std::unique_ptr<ControlLattice> control);
    Rules rules(const Push& push) const override;
    Status check_push(const Push& push) override;
    std::vector<std::int32_t> nodes_around(const Push& push) const override;
    double folded_cells(std::span<const Vec3d> positions_mm) override;
    void hold_nodes() noexcept override;
    void keep() override;
    void take_back() noexcept override;
    Status step() override;
    Status place_scan(std::span<const Vec3d> positions_mm) const override;
    void take_displacements(std::span<const Vec3d> positions_mm) const;
    void renew_sources() noexcept;
    void settle() noexcept;
    Result<CutReport> cut_along(const CutSurface& surface);
    Result<std::vector<CutTriangle>> ribbon_at_rest(const CutSurface& surface) const;
    Vec3d rest_of(const ControlPosition& position) const;
    Vec3d rest_of(Vec3d point_mm, Vec3d& shift) const;
    std::vector<std::int32_t> crossed_links() const;

    SpringDeformationSettings m_settings;
    mutable std::vector<Vec3d> m_displacements;  ///< as shown by the elements
    std::vector<std::int32_t> m_former;          ///< released, and possibly not at rest yet: sorted
    std::vector<std::int32_t> m_former_kept;     ///< for take_back()
    std::vector<std::int32_t> m_loose;           ///< scratch
    std::vector<Vec3d> m_no_forces, m_moves;     ///< of all nodes; m_moves: as of folded_cells()
    std::vector<std::uint8_t> m_stretched;
    std::optional<ControlPosition> m_position;  ///< of the present push
    std::int32_t m_active_nodes = 0;
};

}  // namespace pliant
