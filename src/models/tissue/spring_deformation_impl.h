// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Data of a SpringDeformation.

#pragma once

#include <pliant/tissues.h>

#include <map>
#include <vector>

namespace pliant {

struct SpringDeformation::Impl {
    Impl(const SpringDeformationSettings& s, std::unique_ptr<ControlLattice> c, SpringTissue t)
        : settings(s), control(std::move(c)), tissue(std::move(t)) {
        displacements.assign(std::size_t(control->node_count()), Vec3d{0, 0, 0});
        for (const SpringNode& node : tissue.network().nodes()) fixed += node.fixed;
        // So that nothing fails once a tool has been released or time has passed.
        const std::size_t count = displacements.size();
        held.reserve(count);
        former.reserve(2 * count);
        loose.reserve(count);
        held_places.reserve(count);
        no_forces.assign(count, Vec3d{0, 0, 0});
        node_places.resize(count);
        node_moves.resize(count);
        stretched.resize(count);
    }

    bool is_fixed(std::int32_t n) const { return tissue.network().nodes()[std::size_t(n)].fixed; }
    std::vector<std::int32_t> nodes_at(const Push& push, const ControlPlace& place) const;
    using Tools = std::map<std::uint32_t, std::vector<std::int32_t>>;
    Result<PushReport> push(std::uint32_t tool, const Push& push);
    Result<SpringMotion> step(int count);
    Status set_positions(std::span<const Vec3d> positions_mm);
    Result<CutReport> cut(const CutSurface& surface);
    Status set_shape(std::span<const Vec3d> positions_mm, std::span<const CutTriangle> cuts_mm);
    Result<std::vector<CutTriangle>> at_rest(const CutSurface& surface) const;
    Vec3d rest_of(const ControlPlace& place) const;
    Vec3d rest_of(Vec3d point_mm, Vec3d& shift) const;
    std::vector<std::int32_t> crossed_links() const;
    std::uint64_t hash_of_cuts() const;
    Result<DepthFound> find_depth(double threshold_mm, std::int32_t max_depth) const;
    Tools with(std::uint32_t tool, std::vector<std::int32_t> nodes) const;
    void let_go_of(std::uint32_t tool) noexcept;
    void renew_sources() noexcept;
    /// Moves the held nodes by a shift, and time by a few steps. @returns the reason if they can't
    /// move
    Status stride(std::span<const std::int32_t> nodes, Vec3d shift) noexcept;
    /// Whether a cell is folded, or nearly folded.
    bool folds() noexcept;
    void stop() noexcept;
    void come_to_rest() noexcept;
    void put(std::span<const Vec3d> positions) noexcept;  ///< with zero velocity
    /// Transfers the nodes' positions to the elements: when these are read, not in each step.
    Status show() noexcept;

    SpringDeformationSettings settings;
    std::unique_ptr<ControlLattice> control;
    SpringTissue tissue;
    std::vector<Vec3d> displacements;  ///< as shown by the elements
    Tools tools;
    std::vector<std::int32_t> held;              ///< by all tools, in the tissue's order
    std::vector<std::int32_t> former;            ///< released, and possibly not at rest yet: sorted
    std::vector<Vec3d> node_places, node_moves;  ///< of all nodes, as of the last folds()
    std::vector<std::uint8_t> stretched;
    std::vector<std::int32_t> loose;            ///< scratch
    std::vector<Vec3d> held_places, no_forces;  ///< likewise; no_forces is for all nodes
    bool settled = true;
    bool is_shown = true;  ///< whether the control lattice has the tissue's positions
    std::int32_t fixed = 0;
};

}  // namespace pliant
