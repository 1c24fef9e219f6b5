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

Vec3d inner_force(const SpringNetwork& network, const SpringState& state, std::int32_t node,
                  double time_step, bool with_damping) {
    const Vec3d here = state.place(node);
    Vec3d force{0, 0, 0};
    for (const auto& neighbour : network.neighbours(node)) {
        const SpringLink& link = network.links()[std::size_t(neighbour.link)];
        const Vec3d r = here - state.place(neighbour.node);
        const double length = norm(r);
        if (!(length > 0)) continue;  // undefined direction
        force = force - (link.stiffness * (length - link.rest_length) / length) * r;
        if (!with_damping || link.damping == 0) continue;
        const Vec3d moved = (here - state.place_before(node)) -
                            (state.place(neighbour.node) - state.place_before(neighbour.node));
        force = force - (link.damping / time_step * dot(r, moved) / (length * length)) * r;
    }
    const auto place = [&](std::int32_t n) { return state.place(n); };
    const auto rest = [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; };
    for (const std::int32_t c : network.cells_of(node)) {
        const SpringCell& cell = network.cells()[std::size_t(c)];
        if (cell.bulk == 0 || network.is_cell_cut(std::size_t(c))) continue;
        const double rest_volume = cell_volume(cell, rest);
        const int corner =
            int(std::find(cell.nodes.begin(), cell.nodes.end(), node) - cell.nodes.begin());
        force = force - (cell.bulk * (cell_volume(cell, place) / rest_volume - 1)) *
                            volume_gradient(cell, corner, place);
    }
    return force;
}

}  // namespace pliant
