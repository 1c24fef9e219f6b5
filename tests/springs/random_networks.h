// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Random connected networks, and a plain step to compare with.

#pragma once

#include <pliant/models/springs.h>

#include <algorithm>
#include <utility>

#include "springs/cell_volume.h"
#include "support/random.h"

namespace pliant::test {

/// A tree with more links added: some twice, lengths and stiffness by chance, a few nodes fixed.
inline SpringParts random_parts(Random& random, int node_count, bool damped) {
    SpringParts parts;
    for (int n = 0; n < node_count; ++n)
        parts.nodes.push_back({.rest = random.vector(5),
                               .mass = random.ratio(0.5, 2),
                               .damping = damped ? random.real(0, 3) : 0,
                               .fixed = n > 0 && random.whole(0, 9) == 0});
    const auto add = [&](int a, int b) {
        const Vec3d r = parts.nodes[std::size_t(a)].rest - parts.nodes[std::size_t(b)].rest;
        parts.links.push_back({.a = a,
                               .b = b,
                               .stiffness = random.ratio(0.1, 10),
                               .damping = damped ? random.real(0, 0.3) : 0,
                               .rest_length = norm(r) * random.real(0.9, 1.1)});
    };
    for (int n = 1; n < node_count; ++n) add(n, random.whole(std::max(0, n - 9), n - 1));
    for (int n = 0; n < 2 * node_count; ++n) {
        const int a = random.whole(0, node_count - 1), b = random.whole(0, node_count - 1);
        if (a != b) add(a, b);
    }
    return parts;
}

/// A block of hexahedra with volume energy and slightly shifted nodes.
inline SpringParts random_block(Random& random, Vec3i size, double bulk, bool damped) {
    auto parts = springs_of_lattice({.size = size,
                                     .stiffness = {2, 3, 4},
                                     .link_damping = damped ? 0.1 : 0,
                                     .node_damping = damped ? 1.0 : 0,
                                     .bulk = bulk});
    for (SpringNode& node : parts->nodes) {
        node.rest = node.rest + random.vector(0.1);
        node.fixed = node.rest.z < 0.5;
    }
    for (SpringLink& link : parts->links) link.rest_length = -1;
    return std::move(*parts);
}

/// One step of [Choi2004, Eq. 5, 7, 8] as it is written, node by node in the given order, which
/// doesn't matter.
struct PlainStepper {
    const SpringNetwork& network;
    double h;
    std::vector<Vec3d> x, before, load;

    explicit PlainStepper(const SpringNetwork& n, double step) : network(n), h(step) {
        for (const SpringNode& node : network.nodes()) x.push_back(node.rest);
        before = x;
        load.assign(x.size(), {0, 0, 0});
    }
    /// @param seen  positions of neighbours, [node]; @param seen_before  theirs a step earlier
    Vec3d next(std::int32_t i, const std::vector<Vec3d>& seen,
               const std::vector<Vec3d>& seen_before) const {
        const auto n = std::size_t(i);
        Vec3d force = load[n];
        for (const SpringLink& link : network.links()) {
            if (link.a != i && link.b != i) continue;
            const auto j = std::size_t(link.a == i ? link.b : link.a);
            const Vec3d r = x[n] - seen[j];
            const Vec3d u = (1 / norm(r)) * r;
            const Vec3d v = (1 / h) * ((x[n] - before[n]) - (seen[j] - seen_before[j]));
            force = force -
                    (link.stiffness * (norm(r) - link.rest_length) + link.damping * dot(v, u)) * u;
        }
        for (const SpringCell& cell : network.cells()) {
            const auto end = cell.nodes.begin() + cell.node_count;
            if (cell.bulk == 0 || std::find(cell.nodes.begin(), end, i) == end) continue;
            const double rest = cell_volume(
                cell, [&](std::int32_t k) { return network.nodes()[std::size_t(k)].rest; });
            const auto volume_at = [&](Vec3d here) {
                return cell_volume(
                    cell, [&](std::int32_t k) { return k == i ? here : seen[std::size_t(k)]; });
            };
            // It is linear in each coordinate of a corner, so differences are its gradient.
            const double pressure = cell.bulk * (volume_at(x[n]) / rest - 1);
            for (int c = 0; c < 3; ++c) {
                Vec3d step{0, 0, 0};
                step[c] = 0.25;
                force[c] -= pressure * (volume_at(x[n] + step) - volume_at(x[n] - step)) / 0.5;
            }
        }
        const double m = network.nodes()[n].mass, d = network.nodes()[n].damping;
        return (1 / (m / (h * h) + d / (2 * h))) *
               (force + (m / (h * h)) * (2.0 * x[n] - before[n]) + (d / (2 * h)) * before[n]);
    }
    void step(const TransmittalOrder& order) {
        const std::vector<Vec3d> old = x, old_before = before;
        for (const std::int32_t i : order.nodes) {
            const Vec3d position = next(i, old, old_before);
            before[std::size_t(i)] = x[std::size_t(i)];
            x[std::size_t(i)] = position;
        }
    }
};

}  // namespace pliant::test
