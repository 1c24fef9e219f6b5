// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What a SpringDeformation holds.

#pragma once

#include <pliant/spring_deformation.h>

#include <map>
#include <vector>

namespace pliant {

struct SpringDeformation::Impl {
    Impl(const SpringDeformationSettings& s, std::unique_ptr<ControlLattice> c, SpringTissue t)
        : settings(s), control(std::move(c)), tissue(std::move(t)) {
        displacements.assign(std::size_t(control->node_count()), Vec3d{0, 0, 0});
        for (const SpringNode& node : tissue.network().nodes()) fixed += node.fixed;
    }

    bool is_fixed(std::int32_t n) const { return tissue.network().nodes()[std::size_t(n)].fixed; }
    std::vector<std::int32_t> nodes_at(const Push& push, const ControlPlace& place) const;
    void grab(std::uint32_t tool, std::vector<std::int32_t> nodes);
    void renew_sources();
    /// Nodes that tools hold go by a shift, time by a few steps. @returns whether they could
    bool stride(std::span<const std::int32_t> nodes, Vec3d shift);
    /// Whether a cell is folded, or nearly.
    bool folds();
    void stop();
    void come_to_rest();
    void put(std::span<const Vec3d> places);  ///< with no speed
    /// Where the nodes are now, to the elements: when somebody looks, not in each step.
    void show();

    SpringDeformationSettings settings;
    std::unique_ptr<ControlLattice> control;
    SpringTissue tissue;
    std::vector<Vec3d> displacements;  ///< as shown
    std::map<std::uint32_t, std::vector<std::int32_t>> tools;
    std::vector<std::int32_t> held;              ///< by all tools, in the tissue's order
    std::vector<std::int32_t> former;            ///< let go, and perhaps not at rest yet: sorted
    std::vector<Vec3d> node_places, node_moves;  ///< of all nodes, as folds() saw them
    std::vector<std::uint8_t> stretched;
    bool settled = true;
    bool is_shown = true;  ///< whether the control lattice is where the tissue is
    std::int32_t fixed = 0;
};

}  // namespace pliant
