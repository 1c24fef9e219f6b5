// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/research/springs.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/small_matrix.h"
#include "springs/cell_volume.h"
#include "springs/stability.h"

namespace pliant {
namespace {

/// Largest eigenvalue of 2 D_i of the stiffness at rest, as SpringNetwork::stable_time_step has it.
double largest_stiffness(const SpringNetwork& network, std::int32_t i) {
    const auto rest = [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; };
    Mat3d sum{};
    for (const auto& neighbour : network.neighbours(i)) {
        const SpringLink& link = network.links()[std::size_t(neighbour.link)];
        const Vec3d r = rest(i) - rest(neighbour.node);
        const double length = norm(r);
        const double across = length > 0
                                  ? link.stiffness * std::max(0.0, 1 - link.rest_length / length)
                                  : link.stiffness;
        for (int a = 0; a < 3; ++a) sum.columns[a][a] += 2 * across;
        if (length > 0) add_outer(sum, (1 / length) * r, 2 * (link.stiffness - across));
    }
    for (const std::int32_t c : network.cells_of(i)) {
        const SpringCell& cell = network.cells()[std::size_t(c)];
        if (network.is_cell_cut(std::size_t(c)) || cell.bulk == 0) continue;
        const auto corner = std::find(cell.nodes.begin(), cell.nodes.end(), i);
        add_outer(sum, volume_gradient(cell, int(corner - cell.nodes.begin()), rest),
                  cell.node_count * cell.bulk / cell_volume(cell, rest));
    }
    return largest_eigenvalue(sum, Scaling::Reciprocal);
}

}  // namespace

double stable_time_step(const SpringNetwork& network, SeenPositions seen) {
    double step = network.stable_time_step();
    if (seen == SeenPositions::Old) return step;
    // With K = D + L + Lᵀ and new positions in L, amplitudes don't grow if h·xᵀ(K − L)x ≤ xᵀCx; and
    // K − L ≤ 2D for every subset L of the neighbours.
    for (std::int32_t i = 0; i < network.node_count(); ++i) {
        const SpringNode& node = network.nodes()[std::size_t(i)];
        if (node.fixed) continue;
        const double largest = largest_stiffness(network, i);
        if (largest > 0) step = std::min(step, node.damping / largest);
    }
    return step;
}

OrderedTransmittal::OrderedTransmittal(SpringNetwork network, TransmittalOrder order,
                                       SeenPositions seen, double time_step)
    : m_network(std::move(network)),
      m_order(std::move(order)),
      m_seen(seen),
      m_time_step(time_step) {
    for (const SpringNode& node : m_network.nodes()) m_now.push_back(node.rest);
    m_before = m_now;
    m_load.assign(m_now.size(), {0, 0, 0});
}

Result<OrderedTransmittal> OrderedTransmittal::create(SpringNetwork network,
                                                      std::span<const std::int32_t> sources,
                                                      std::int32_t depth, SeenPositions seen,
                                                      double time_step) {
    if (!(time_step > 0))
        return invalid("time_step: expected one above 0, found " + std::to_string(time_step));
    if (network.has_branches()) return invalid("network: expected one without Maxwell branches");
    auto order = transmittal_order(network, sources, depth);
    if (!order.ok()) return order.error();
    return OrderedTransmittal(std::move(network), std::move(*order), seen, time_step);
}

void OrderedTransmittal::set_state(std::int32_t node, Vec3d position, Vec3d moved) {
    m_now[std::size_t(node)] = position;
    m_before[std::size_t(node)] = position - moved;
}

/// @param seen  positions of the neighbours, [node]; seen_before: theirs a step earlier
Vec3d OrderedTransmittal::next(std::int32_t i, std::span<const Vec3d> seen,
                               std::span<const Vec3d> seen_before) const {
    const auto n = std::size_t(i);
    const double h = m_time_step;
    const Vec3d now = m_now[n], before = m_before[n];
    Vec3d force = m_load[n];
    for (const auto& neighbour : m_network.neighbours(i)) {
        const SpringLink& link = m_network.links()[std::size_t(neighbour.link)];
        const auto j = std::size_t(neighbour.node);
        const Vec3d r = now - seen[j];
        const double length = norm(r);
        const Vec3d u = (1 / length) * r;
        const Vec3d v = (1 / h) * ((now - before) - (seen[j] - seen_before[j]));
        force =
            force - (link.stiffness * (length - link.rest_length) + link.damping * dot(v, u)) * u;
    }
    for (const std::int32_t c : m_network.cells_of(i)) {
        const SpringCell& cell = m_network.cells()[std::size_t(c)];
        if (m_network.is_cell_cut(std::size_t(c)) || cell.bulk == 0) continue;
        const auto corner = std::find(cell.nodes.begin(), cell.nodes.end(), i);
        const auto rest = [&](std::int32_t k) { return m_network.nodes()[std::size_t(k)].rest; };
        const auto position = [&](std::int32_t k) { return k == i ? now : seen[std::size_t(k)]; };
        const double pressure =
            cell.bulk * (cell_volume(cell, position) / cell_volume(cell, rest) - 1);
        force =
            force - pressure * volume_gradient(cell, int(corner - cell.nodes.begin()), position);
    }
    const double inertia = m_network.nodes()[n].mass / (h * h),
                 drag = m_network.nodes()[n].damping / (2 * h);
    return (1 / (inertia + drag)) * (force + inertia * (2.0 * now - before) + drag * before);
}

void OrderedTransmittal::step_once() {
    const std::vector<Vec3d> old = m_now, old_before = m_before;
    std::vector<Vec3d> layer = m_now, layer_before = m_before;
    for (std::size_t l = 0; l + 1 < m_order.layers.size(); ++l) {
        if (m_seen == SeenPositions::NewLayers) {
            layer = m_now;
            layer_before = m_before;
        }
        for (std::int32_t k = m_order.layers[l]; k < m_order.layers[l + 1]; ++k) {
            const std::int32_t i = m_order.nodes[std::size_t(k)];
            const Vec3d position = m_seen == SeenPositions::Old ? next(i, old, old_before)
                                   : m_seen == SeenPositions::NewLayers
                                       ? next(i, layer, layer_before)
                                       : next(i, m_now, m_before);
            m_before[std::size_t(i)] = m_now[std::size_t(i)];
            m_now[std::size_t(i)] = position;
        }
    }
}

void OrderedTransmittal::step(std::int32_t count) {
    for (std::int32_t n = 0; n < count; ++n) step_once();
}

std::vector<Vec3d> OrderedTransmittal::displacements() const {
    std::vector<Vec3d> moved;
    for (std::size_t n = 0; n < m_now.size(); ++n)
        moved.push_back(m_now[n] - m_network.nodes()[n].rest);
    return moved;
}

Vec3d OrderedTransmittal::momentum() const {
    Vec3d sum{0, 0, 0};
    for (std::size_t n = 0; n < m_now.size(); ++n)
        sum = sum + (m_network.nodes()[n].mass / m_time_step) * (m_now[n] - m_before[n]);
    return sum;
}

}  // namespace pliant
