// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/state.h"

#include <algorithm>

#include "base/errors.h"
#include "base/small_matrix.h"
#include "base/text.h"
#include "springs/cell_volume.h"
#include "springs/stability.h"

namespace pliant {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

/// 2 D_i of stiffness and damping.
struct Bounds {
    Mat3d stiffness{}, damping{};
};

Bounds bounds_of(const SpringNetwork& network, std::int32_t i, std::span<const Vec3d> positions) {
    const auto rest = [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; };
    const auto position = [&](std::int32_t n) {
        return positions.empty() ? rest(n) : positions[std::size_t(n)];
    };
    Bounds bounds;
    for (const auto& neighbour : network.neighbours(i)) {
        const SpringLink& link = network.links()[std::size_t(neighbour.link)];
        const Vec3d r = position(i) - position(neighbour.node);
        const double length = norm(r);
        // In the fastest motion a branch acts with its whole stiffness (MaxwellBranch).
        const double stiffness = link.stiffness + link.branch_stiffness;
        // The transverse stiffness is positive only for a stretched link; a link of zero length may
        // have any direction.
        const double across =
            length > 0 ? stiffness * std::max(0.0, 1 - link.rest_length / length) : stiffness;
        for (int a = 0; a < 3; ++a) bounds.stiffness.columns[a][a] += 2 * across;
        if (!(length > 0)) continue;
        add_outer(bounds.stiffness, (1 / length) * r, 2 * (stiffness - across));
        add_outer(bounds.damping, (1 / length) * r, 2 * link.damping);
    }
    for (const std::int32_t c : network.cells_of(i)) {
        const SpringCell& cell = network.cells()[std::size_t(c)];
        if (network.is_cell_cut(std::size_t(c)) || cell.bulk == 0) continue;
        const int corner =
            int(std::find(cell.nodes.begin(), cell.nodes.end(), i) - cell.nodes.begin());
        add_outer(bounds.stiffness, volume_gradient(cell, corner, position),
                  cell.node_count * cell.bulk / cell_volume(cell, rest));
    }
    return bounds;
}

}  // namespace

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

// Bounds of the eigenvalues of M⁻¹K. For a link along n,
//
//   k (n·(u_i − u_j))² ≤ 2k (n·u_i)² + 2k (n·u_j)²,
//
// so K ≤ 2 diag(D_i) with D_i = Σ k n nᵀ, and likewise for a cell
// (Σ g_a·u_a)² ≤ corners·Σ (g_a·u_a)². Only 3×3 blocks remain.

double stable_time_step(const SpringNetwork& network, std::span<const Vec3d> positions) {
    double shortest = kNone;
    for (std::int32_t i = 0; i < network.node_count(); ++i) {
        const SpringNode& node = network.nodes()[std::size_t(i)];
        if (node.fixed) continue;
        const Bounds bounds = bounds_of(network, i, positions);
        const double lambda = largest_eigenvalue(bounds.stiffness, Scaling::Reciprocal) / node.mass;
        const double gamma = largest_eigenvalue(bounds.damping, Scaling::Reciprocal) / node.mass;
        // h²λ + 2hγ = 4, in a form without cancellation.
        shortest = std::min(shortest, 4 / (gamma + std::sqrt(gamma * gamma + 4 * lambda)));
    }
    return shortest;
}

Result<RaisedMasses> raise_masses(SpringParts& parts, double time_step) noexcept {
    return attempt([&]() -> Result<RaisedMasses> {
        if (!(time_step > 0 && std::isfinite(time_step)))
            return invalid("raise_masses: expected a time step above 0, found " +
                           short_text(time_step));
        const auto network = SpringNetwork::create(parts);
        if (!network.ok()) return network.error();
        RaisedMasses raised;
        double before = 0, added = 0;
        for (std::int32_t n = 0; n < network->node_count(); ++n) {
            SpringNode& node = parts.nodes[std::size_t(n)];
            before += node.mass;
            if (node.fixed) continue;
            const Bounds bounds = bounds_of(*network, n, {});
            const double stiffness = largest_eigenvalue(bounds.stiffness, Scaling::Reciprocal);
            const double damping = largest_eigenvalue(bounds.damping, Scaling::Reciprocal);
            // The bound of stable_time_step is not below the step in spite of rounding.
            const double least =
                (1 + 1e-12) * (time_step * time_step * stiffness + 2 * time_step * damping) / 4;
            if (!(node.mass < least)) continue;
            added += least - node.mass;
            node.mass = least;
            ++raised.nodes;
        }
        raised.share = added / before;
        return raised;
    });
}

double SpringNetwork::stable_time_step() const {
    return pliant::stable_time_step(*this, std::span<const Vec3d>{});
}

}  // namespace pliant
