// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/state.h"

#include <algorithm>

#include "springs/cell_volume.h"

namespace pliant {

void set_to_rest(const SpringNetwork& network, SpringState& state) {
    const auto count = std::size_t(network.node_count());
    for (int c = 0; c < 3; ++c) {
        state.x[c].resize(count);
        for (std::size_t n = 0; n < count; ++n) state.x[c][n] = network.nodes()[n].rest[c];
        state.before[c] = state.x[c];
        state.load[c].resize(count);
    }
    state.is_held.resize(count);
    state.is_touched.resize(count);
}

void renew_touched(SpringState& state) noexcept {
    std::fill(state.is_touched.begin(), state.is_touched.end(), std::uint8_t(0));
    for (const std::int32_t n : state.loaded) state.is_touched[std::size_t(n)] = 1;
    for (const std::int32_t n : state.held) state.is_touched[std::size_t(n)] = 1;
}

namespace {

double stretch_of(const SpringState& state, const SpringLink& link) {
    return norm(state.position(link.a) - state.position(link.b)) - link.rest_length;
}

}  // namespace

void relax_branches(const SpringNetwork& network, SpringState& state, double time_step) {
    state.branch.resize(network.has_branches() ? network.links().size() : 0);
    for (std::size_t l = 0; l < state.branch.size(); ++l) {
        const SpringLink& link = network.links()[l];
        state.branch[l] = branch_of(link, time_step).pull * stretch_of(state, link);
    }
}

double branch_force(const SpringNetwork& network, const SpringState& state, std::size_t link,
                    double time_step) {
    if (state.branch.empty() || network.is_cut(link)) return 0;
    const SpringLink& properties = network.links()[link];
    return branch_of(properties, time_step).pull * stretch_of(state, properties) -
           state.branch[link];
}

Vec3d branches_force(const SpringNetwork& network, const SpringState& state, std::int32_t node,
                     double time_step) {
    Vec3d force{0, 0, 0};
    if (state.branch.empty()) return force;
    for (const auto& neighbour : network.neighbours(node)) {
        const Vec3d r = state.position(node) - state.position(neighbour.node);
        const double length = norm(r);
        if (!(length > 0)) continue;  // undefined direction
        force = force -
                (branch_force(network, state, std::size_t(neighbour.link), time_step) / length) * r;
    }
    return force;
}

Vec3d static_force(const SpringNetwork& network, const SpringState& state, std::int32_t node) {
    const Vec3d here = state.position(node);
    Vec3d force{0, 0, 0};
    for (const auto& neighbour : network.neighbours(node)) {
        const SpringLink& link = network.links()[std::size_t(neighbour.link)];
        const Vec3d r = here - state.position(neighbour.node);
        const double length = norm(r);
        if (!(length > 0)) continue;  // undefined direction
        force = force - (link.stiffness * (length - link.rest_length) / length) * r;
    }
    const auto position = [&](std::int32_t n) { return state.position(n); };
    const auto rest = [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; };
    for (const std::int32_t c : network.cells_of(node)) {
        const SpringCell& cell = network.cells()[std::size_t(c)];
        if (cell.bulk == 0 || network.is_cell_cut(std::size_t(c))) continue;
        const double rest_volume = cell_volume(cell, rest);
        const int corner =
            int(std::find(cell.nodes.begin(), cell.nodes.end(), node) - cell.nodes.begin());
        force = force - (cell.bulk * (cell_volume(cell, position) / rest_volume - 1)) *
                            volume_gradient(cell, corner, position);
    }
    return force;
}

}  // namespace pliant
