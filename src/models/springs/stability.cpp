// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bounds of the eigenvalues of M⁻¹K. For a link along n,
//
//   k (n·(u_i − u_j))² ≤ 2k (n·u_i)² + 2k (n·u_j)²,
//
// so K ≤ 2 diag(D_i) with D_i = Σ k n nᵀ, and likewise for a cell
// (Σ g_a·u_a)² ≤ corners·Σ (g_a·u_a)². Only 3×3 blocks remain.

#include "springs/stability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/errors.h"
#include "base/small_matrix.h"
#include "base/text.h"
#include "springs/cell_volume.h"

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
