// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Positions, loads and held nodes: the state shared by all solvers.

#pragma once

#include <pliant/springs.h>

namespace pliant {

struct SpringState {
    std::vector<double> x[3],
        before[3];  ///< current and previous positions; their difference gives the velocity
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

/// Sets all nodes to their rest positions.
void set_to_rest(const SpringNetwork& network, SpringState& state);

/// Updates is_touched after a change of the loaded or held nodes.
void renew_touched(SpringState& state) noexcept;

/// −f of the links and the volume energy on one node. @param with_damping  includes link damping
Vec3d inner_force(const SpringNetwork& network, const SpringState& state, std::int32_t node,
                  double time_step, bool with_damping);

}  // namespace pliant
