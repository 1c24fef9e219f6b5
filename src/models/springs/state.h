// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Positions, loads and held nodes: the state shared by all solvers.

#pragma once

#include <pliant/models/springs.h>

#include <cmath>

namespace pliant {

/// A link's Maxwell branch in steps of h. With the link's stretch x, the stretch e of the dashpot
/// follows de/dt = (x − e)/τ, with the mean of x at both ends of a step:
///
///   e⁺ = a e + (1 − a)(x + x⁺)/2,   a = e^(−h/τ),   force q = k'(x − e)
///
/// Stored is s, the part of k'e that is known before x:
///
///   q = pull · x − s,         pull = k'(1 + a)/2
///   s⁺ = keep · s + gain · x,   keep = a, gain = k'(1 − a²)/2
///
/// In the fastest motion of central differences, x⁺ = −x, q is k'x: the branch counts with its
/// whole stiffness in the stability bound. In all others it takes energy.
struct MaxwellBranch {
    double pull = 0, keep = 0, gain = 0;
};
inline MaxwellBranch branch_of(const SpringLink& link, double time_step) {
    if (link.branch_stiffness == 0) return {};
    const double keep = std::exp(-time_step / link.branch_time);
    return {0.5 * link.branch_stiffness * (1 + keep), keep,
            0.5 * link.branch_stiffness * (1 - keep * keep)};
}

struct SpringState {
    std::vector<double> x[3],
        before[3];  ///< current and previous positions; their difference gives the velocity
    std::vector<double> load[3];
    std::vector<double> branch;  ///< [link] s of MaxwellBranch; empty without branches
    std::vector<std::int32_t> loaded, held;
    std::vector<std::uint8_t> is_held, is_touched;  ///< [node]; touched: loaded or held

    Vec3d position(std::int32_t node) const {
        const auto n = std::size_t(node);
        return {x[0][n], x[1][n], x[2][n]};
    }
    Vec3d position_before(std::int32_t node) const {
        const auto n = std::size_t(node);
        return {before[0][n], before[1][n], before[2][n]};
    }
    Vec3d load_of(std::int32_t node) const {
        const auto n = std::size_t(node);
        return {load[0][n], load[1][n], load[2][n]};
    }
    void put(std::int32_t node, Vec3d position) {
        for (int c = 0; c < 3; ++c) x[c][std::size_t(node)] = position[c];
    }
    void put_before(std::int32_t node, Vec3d position) {
        for (int c = 0; c < 3; ++c) before[c][std::size_t(node)] = position[c];
    }
    bool moves(const SpringNetwork& network, std::int32_t node) const {
        return !network.nodes()[std::size_t(node)].fixed && !is_held[std::size_t(node)];
    }
};

/// Sets all nodes to their rest positions.
void set_to_rest(const SpringNetwork& network, SpringState& state);

/// Lets all Maxwell branches relax in the present shape.
void relax_branches(const SpringNetwork& network, SpringState& state, double time_step);

/// Force q of a link's Maxwell branch.
double branch_force(const SpringNetwork& network, const SpringState& state, std::size_t link,
                    double time_step);

/// Updates is_touched after a change of the loaded or held nodes.
void renew_touched(SpringState& state) noexcept;

/// −f of the links and the volume energy on one node, without damping.
Vec3d static_force(const SpringNetwork& network, const SpringState& state, std::int32_t node);
/// −q of the Maxwell branches on one node.
Vec3d branches_force(const SpringNetwork& network, const SpringState& state, std::int32_t node,
                     double time_step);

}  // namespace pliant
