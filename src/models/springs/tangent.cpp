// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/tangent.h"

#include <algorithm>

#include "base/small_matrix.h"
#include "springs/cell_volume.h"
#include "springs/stability.h"

namespace pliant {
namespace {

double product_of(std::span<const Vec3d> a, std::span<const Vec3d> b) {
    double sum = 0;
    for (std::size_t n = 0; n < a.size(); ++n) sum += dot(a[n], b[n]);
    return sum;
}

double longest_of(std::span<const Vec3d> moves) {
    double longest = 0;
    for (const Vec3d& move : moves) longest = std::max(longest, norm(move));
    return longest;
}

}  // namespace

void Tangent::renew(const SpringNetwork& network, const SpringState& state,
                    std::span<const std::uint8_t> moves, TangentKind kind, double inertia,
                    double drag, double links) {
    const auto count = std::size_t(network.node_count());
    const auto position = [&](std::int32_t n) { return state.position(n); };
    const auto rest = [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; };
    m_links.resize(network.links().size());
    m_precondition.assign(count, Mat3d{});
    m_diagonal.resize(count);
    m_moves.assign(moves.begin(), moves.end());
    for (std::size_t n = 0; n < count; ++n) {
        m_diagonal[n] = inertia * network.nodes()[n].mass + drag * network.nodes()[n].damping;
        for (int c = 0; c < 3; ++c) m_precondition[n].columns[c][c] = m_diagonal[n];
    }
    for (std::size_t l = 0; l < m_links.size(); ++l) {
        const SpringLink& link = network.links()[l];
        const Vec3d r = position(link.a) - position(link.b);
        const double length = norm(r);
        m_links[l] = {};
        if (network.is_cut(l) || !(length > 0)) continue;
        Link& t = m_links[l];
        t.n = (1 / length) * r;
        const double across = link.stiffness * (1 - link.rest_length / length);
        t.across = kind == TangentKind::Exact ? across : std::max(0.0, across);
        t.along = link.stiffness - t.across;
        t.damping = links * link.damping;
        for (const std::int32_t end : {link.a, link.b}) {
            Mat3d& block = m_precondition[std::size_t(end)];
            const double kept = std::max(0.0, across);
            add_outer(block, t.n, link.stiffness - kept + t.damping);
            for (int c = 0; c < 3; ++c) block.columns[c][c] += kept;
        }
    }
    m_cell.assign(network.has_volume_energy() ? network.cells().size() : 0, 0);
    m_gradient.resize(8 * m_cell.size());
    m_pressure.assign(kind == TangentKind::Exact ? m_cell.size() : 0, 0);
    m_position.resize(m_pressure.empty() ? 0 : count);
    for (std::size_t n = 0; n < m_position.size(); ++n) m_position[n] = position(std::int32_t(n));
    for (std::size_t c = 0; c < m_cell.size(); ++c) {
        const SpringCell& cell = network.cells()[c];
        if (cell.bulk == 0 || network.is_cell_cut(c)) continue;
        const double rest_volume = cell_volume(cell, rest);
        m_cell[c] = cell.bulk / rest_volume;
        if (!m_pressure.empty())
            m_pressure[c] = m_cell[c] * (cell_volume(cell, position) - rest_volume);
        for (int n = 0; n < cell.node_count; ++n) {
            const Vec3d g = volume_gradient(cell, n, position);
            m_gradient[8 * c + std::size_t(n)] = g;
            add_outer(m_precondition[std::size_t(cell.nodes[std::size_t(n)])], g, m_cell[c]);
        }
    }
    for (Mat3d& block : m_precondition) {
        // A node without stiffness in some direction doesn't move in it.
        const double size = largest_eigenvalue(block, Scaling::Reciprocal);
        for (int c = 0; c < 3; ++c) block.columns[c][c] += size > 0 ? 1e-12 * size : 1;
        block = inverse(block);
    }
}

Vec3d Tangent::product(const SpringNetwork& network, std::span<const Vec3d> v, std::int32_t node,
                       bool whole) const {
    const auto n = std::size_t(node);
    Vec3d sum = (whole ? m_diagonal[n] : 0) * v[n];
    for (const auto& neighbour : network.neighbours(node)) {
        const Link& t = m_links[std::size_t(neighbour.link)];
        const Vec3d d = v[n] - v[std::size_t(neighbour.node)];
        sum = sum + ((t.along + (whole ? t.damping : 0)) * dot(t.n, d)) * t.n + t.across * d;
    }
    return sum;
}

void Tangent::multiply_cells(const SpringNetwork& network, std::span<const Vec3d> v,
                             std::span<Vec3d> out) const {
    for (std::size_t c = 0; c < m_cell.size(); ++c) {
        if (m_cell[c] == 0) continue;
        const SpringCell& cell = network.cells()[c];
        double sum = 0;
        for (int n = 0; n < cell.node_count; ++n)
            sum +=
                dot(m_gradient[8 * c + std::size_t(n)], v[std::size_t(cell.nodes[std::size_t(n)])]);
        for (int n = 0; n < cell.node_count; ++n) {
            Vec3d& to = out[std::size_t(cell.nodes[std::size_t(n)])];
            to = to + (m_cell[c] * sum) * m_gradient[8 * c + std::size_t(n)];
        }
        if (m_pressure.empty()) continue;
        for (int n = 0; n < cell.node_count; ++n) {
            Vec3d& to = out[std::size_t(cell.nodes[std::size_t(n)])];
            to = to + m_pressure[c] *
                          volume_gradient_change(
                              cell, n,
                              [&](std::int32_t node) { return m_position[std::size_t(node)]; },
                              [&](std::int32_t node) { return v[std::size_t(node)]; });
        }
    }
}

void Tangent::multiply(const SpringNetwork& network, std::span<const Vec3d> v, bool whole,
                       std::span<Vec3d> out) const {
    for (std::int32_t n = 0; n < network.node_count(); ++n)
        out[std::size_t(n)] = product(network, v, n, whole);
    multiply_cells(network, v, out);
}

/// Computes m_image.
void Tangent::multiply_unknowns(const SpringNetwork& network, std::span<const Vec3d> v) {
    m_image.resize(v.size());
    multiply(network, v, true, m_image);
    for (std::size_t n = 0; n < v.size(); ++n)
        if (!m_moves[n]) m_image[n] = {0, 0, 0};
}

/// Computes m_scaled from m_residual.
void Tangent::precondition() {
    m_scaled.resize(m_residual.size());
    for (std::size_t n = 0; n < m_residual.size(); ++n)
        m_scaled[n] = m_precondition[n] * m_residual[n];
}

std::int32_t Tangent::solve(const SpringNetwork& network, std::span<const Vec3d> right,
                            const SolveLimits& limits, std::vector<Vec3d>& v) {
    const std::size_t count = right.size();
    m_residual.resize(count);
    multiply_unknowns(network, v);
    double scale = 0;
    for (std::size_t n = 0; n < count; ++n) {
        m_residual[n] = m_moves[n] ? right[n] - m_image[n] : Vec3d{0, 0, 0};
        if (m_moves[n]) scale += dot(right[n], right[n]);
    }
    scale = std::max(scale, product_of(m_residual, m_residual));
    const double enough = limits.tolerance * limits.tolerance * scale;
    precondition();
    m_direction = m_scaled;
    double weight = product_of(m_residual, m_scaled);
    for (std::int32_t turn = 0; turn < limits.iterations; ++turn) {
        if (!(product_of(m_residual, m_residual) > enough)) return turn;
        multiply_unknowns(network, m_direction);
        const double curvature = product_of(m_direction, m_image);
        if (!(curvature > 0)) break;
        go_on(v, weight / curvature, weight);
    }
    return limits.iterations + 1;
}

void Tangent::go_on(std::vector<Vec3d>& v, double step, double& weight) {
    for (std::size_t n = 0; n < v.size(); ++n) {
        v[n] = v[n] + step * m_direction[n];
        m_residual[n] = m_residual[n] - step * m_image[n];
    }
    precondition();
    const double last = weight;
    weight = product_of(m_residual, m_scaled);
    for (std::size_t n = 0; n < v.size(); ++n)
        m_direction[n] = m_scaled[n] + (weight / last) * m_direction[n];
}

double Tangent::descend(const SpringNetwork& network, std::span<const Vec3d> force,
                        const SolveLimits& limits, double radius, std::vector<Vec3d>& v) {
    const auto cut_to_radius = [&] {
        const double longest = longest_of(v);
        if (longest > radius)
            for (Vec3d& move : v) move = (radius / longest) * move;
        return longest > radius;
    };
    v.assign(force.size(), {0, 0, 0});
    m_residual.assign(force.begin(), force.end());
    const double enough = limits.tolerance * limits.tolerance * product_of(m_residual, m_residual);
    precondition();
    m_direction = m_scaled;
    double weight = product_of(m_residual, m_scaled);
    for (std::int32_t turn = 0; turn < limits.iterations; ++turn) {
        if (!(product_of(m_residual, m_residual) > enough)) break;
        if (limits.give_up && (*limits.give_up)()) break;
        multiply_unknowns(network, m_direction);
        const double curvature = product_of(m_direction, m_image);
        if (!(curvature > 0)) {
            // Negative curvature: goes downhill to the trust radius.
            const double longest = longest_of(m_direction);
            for (std::size_t n = 0; longest > 0 && n < v.size(); ++n)
                v[n] = v[n] + (2 * radius / longest) * m_direction[n];
            cut_to_radius();
            break;
        }
        go_on(v, weight / curvature, weight);
        if (cut_to_radius()) break;
    }
    multiply_unknowns(network, v);
    return product_of(force, v) - 0.5 * product_of(v, m_image);
}

}  // namespace pliant
