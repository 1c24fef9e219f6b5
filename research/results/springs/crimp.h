// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A bar of 5 × 5 × 9 nodes, held at its foot, as in [Choi2004, Fig. 11], and one with crimped
// fibres:
//
//     │   │        ╱   ╱     every second layer is shifted sideways, so the stiff links along the
//     │   │   →    ╲   ╲     axis are wavy at rest
//     │   │        ╱   ╱

#pragma once

#include <pliant/models/springs.h>

#include <cstddef>
#include <utility>
#include <vector>

namespace pliant::results {

constexpr std::int32_t kLayer = 25, kLayers = 9;

inline std::vector<std::int32_t> top_nodes() {
    std::vector<std::int32_t> nodes;
    for (std::int32_t n = 0; n < kLayer; ++n) nodes.push_back(n + kLayer * (kLayers - 1));
    return nodes;
}

/// A bar with links along z of stiffness 2, all others of 0.05.
inline Result<SpringTissue> crimped_bar(double shift) {
    auto parts = springs_of_lattice({.size = {5, 5, kLayers}, .node_damping = 2});
    if (!parts.ok()) return parts.error();
    for (std::size_t n = 0; n < parts->nodes.size(); ++n) {
        SpringNode& node = parts->nodes[n];
        node.fixed = n < std::size_t(kLayer);
        if (n / std::size_t(kLayer) % 2 == 1) node.rest.x += shift;
    }
    for (SpringLink& link : parts->links) {
        link.stiffness = link.b - link.a == kLayer ? 2 : 0.05;
        link.rest_length = -1;
    }
    auto network = SpringNetwork::create(std::move(*parts));
    if (!network.ok()) return network.error();
    return SpringTissue::create(std::move(*network), {.depth = 20, .time_step = 0.1});
}

/// Mean elongation of the bar, relative to its length.
inline double strain_of(const SpringTissue& bar) {
    double sum = 0;
    for (const std::int32_t n : top_nodes()) sum += bar.displacement(n).z;
    return sum / (kLayer * (kLayers - 1));
}

/// Pulls the top along the axis.
inline Status draw(SpringTissue& bar, double force) {
    const auto top = top_nodes();
    return bar.load(top, std::vector<Vec3d>(top.size(), {0, 0, force / kLayer}));
}

struct LoadPoint {
    double strain, force;
};
/// Equilibria under forces from 0 to `max_force`, in steps of 0.1 up to 4 and of 0.5 beyond.
inline Result<std::vector<LoadPoint>> load_curve(SpringTissue& bar, double max_force) {
    std::vector<LoadPoint> curve{{0, 0}};
    for (double force = 0.1; force <= max_force; force += force < 4 ? 0.1 : 0.5) {
        if (const Status s = draw(bar, force); !s.ok()) return s.error();
        if (const Status s = bar.find_equilibrium(); !s.ok()) return s.error();
        curve.push_back({strain_of(bar), force});
    }
    return curve;
}

/// Slope of a curve between a point and the next.
inline double slope_at(const std::vector<LoadPoint>& curve, std::size_t n) {
    return (curve[n + 1].force - curve[n].force) / (curve[n + 1].strain - curve[n].strain);
}

}  // namespace pliant::results
