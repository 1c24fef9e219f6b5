// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Where the nodes are, and what is done to them: what all solvers share.

#pragma once

#include <pliant/springs.h>

namespace pliant {

struct SpringState {
    std::vector<double> x[3],
        before[3];  ///< places now and one step before; velocity is their difference
    std::vector<double> load[3];
    std::vector<std::int32_t> loaded, held;
    std::vector<std::uint8_t> is_held, is_touched;  ///< [node]; touched: loaded or held

    Vec3d place(std::int32_t node) const {
        const auto n = std::size_t(node);
        return {x[0][n], x[1][n], x[2][n]};
    }
    Vec3d place_before(std::int32_t node) const {
        const auto n = std::size_t(node);
        return {before[0][n], before[1][n], before[2][n]};
    }
    Vec3d load_of(std::int32_t node) const {
        const auto n = std::size_t(node);
        return {load[0][n], load[1][n], load[2][n]};
    }
    void put(std::int32_t node, Vec3d place) {
        for (int c = 0; c < 3; ++c) x[c][std::size_t(node)] = place[c];
    }
    void put_before(std::int32_t node, Vec3d place) {
        for (int c = 0; c < 3; ++c) before[c][std::size_t(node)] = place[c];
    }
    bool moves(const SpringNetwork& network, std::int32_t node) const {
        return !network.nodes()[std::size_t(node)].fixed && !is_held[std::size_t(node)];
    }
};

/// All nodes at their rest places.
void set_to_rest(const SpringNetwork& network, SpringState& state);

/// After the loaded or the held nodes have changed.
void renew_touched(SpringState& state) noexcept;

/// −f of the links and the volume energy of one node. @param with_damping  of links
Vec3d inner_force(const SpringNetwork& network, const SpringState& state, std::int32_t node,
                  double time_step, bool with_damping);

}  // namespace pliant
