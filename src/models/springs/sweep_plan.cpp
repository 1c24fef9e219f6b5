// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/sweep_plan.h"

#include <algorithm>

#include "springs/cell_volume.h"

namespace pliant {
namespace {

/// Minimum length of a row of consecutive nodes that gets separate packs.
constexpr std::size_t kLongRun = 8;

std::size_t run_length(std::span<const std::int32_t> nodes, std::size_t begin) {
    std::size_t end = begin + 1;
    while (end < nodes.size() && nodes[end] == nodes[end - 1] + 1) ++end;
    return end - begin;
}

}  // namespace

/// Orders by number if that gives long rows, otherwise from neighbour to neighbour: a ring of the
/// sheet is then traversed in sequence, so that its neighbours in the next ring are consecutive
/// too.
void SweepPlanner::order_nodes(const SpringNetwork& network) {
    m_walk.assign(m_nodes.begin(), m_nodes.end());
    std::sort(m_nodes.begin(), m_nodes.end());
    std::size_t runs = 0;
    for (std::size_t n = 0; n < m_nodes.size(); n += run_length(m_nodes, n)) ++runs;
    if (m_nodes.size() >= 4 * runs) return;
    constexpr std::int32_t kWaiting = -2;
    for (const std::int32_t node : m_nodes) m_local_of[std::size_t(node)] = kWaiting;
    m_nodes.clear();
    for (const std::int32_t start : m_walk) {
        std::int32_t node = start;
        while (node >= 0 && m_local_of[std::size_t(node)] == kWaiting) {
            m_local_of[std::size_t(node)] = -1;
            m_nodes.push_back(node);
            const auto neighbours = network.neighbours(node);
            const auto next =
                std::find_if(neighbours.begin(), neighbours.end(), [&](const auto& neighbour) {
                    return m_local_of[std::size_t(neighbour.node)] == kWaiting;
                });
            node = next == neighbours.end() ? -1 : next->node;
        }
    }
}

/// Adds the frozen neighbours at both ends of a row, so that all links of the row to one side have
/// one offset.
void SweepPlanner::extend_rows(const SpringNetwork& network) {
    const auto is_seen = [&](std::int32_t node) {
        if (node < 0 || node >= network.node_count() || m_active[std::size_t(node)]) return false;
        const auto neighbours = network.neighbours(node);
        return std::any_of(neighbours.begin(), neighbours.end(), [&](const auto& neighbour) {
            return m_active[std::size_t(neighbour.node)] != 0;
        });
    };
    m_walk.clear();
    for (std::size_t n = 0; n < m_nodes.size();) {
        const std::size_t run = run_length(m_nodes, n);
        const std::int32_t before = m_nodes[n] - 1, after = m_nodes[n + run - 1] + 1;
        const bool is_row = run >= kLongRun;
        if (is_row && is_seen(before) && (m_walk.empty() || m_walk.back() != before))
            m_walk.push_back(before);
        m_walk.insert(m_walk.end(), m_nodes.begin() + std::ptrdiff_t(n),
                      m_nodes.begin() + std::ptrdiff_t(n + run));
        if (is_row && is_seen(after)) m_walk.push_back(after);
        n += run;
    }
    m_nodes.swap(m_walk);
}

void SweepPlanner::add_nodes(const SpringNetwork& network, SweepPlan& plan) {
    plan.active_nodes = std::int32_t(m_nodes.size());
    for (const std::int32_t node : m_nodes) m_active[std::size_t(node)] = 1;
    order_nodes(network);
    extend_rows(network);
    const auto fill_pack = [&] {
        while (plan.nodes.size() % kPack) plan.nodes.push_back(-1);
    };
    std::size_t last_run = 0;
    for (std::size_t n = 0; n < m_nodes.size();) {
        const std::size_t run = run_length(m_nodes, n);
        if (last_run >= kLongRun && run >= kLongRun) fill_pack();
        plan.nodes.insert(plan.nodes.end(), m_nodes.begin() + std::ptrdiff_t(n),
                          m_nodes.begin() + std::ptrdiff_t(n + run));
        n += run;
        last_run = run;
    }
    fill_pack();
}

void SweepPlanner::plan(const SpringNetwork& network, std::span<const std::int32_t> nodes,
                        double time_step, SweepPlan& plan) {
    plan = {};
    plan.nodes.assign(kPack, -1);
    m_local_of.resize(std::size_t(network.node_count()), -1);
    m_active.resize(std::size_t(network.node_count()), 0);
    m_nodes.assign(nodes.begin(), nodes.end());
    add_nodes(network, plan);
    plan.active_end = std::int32_t(plan.nodes.size());
    number(network, plan);
    plan.damped = std::any_of(network.links().begin(), network.links().end(),
                              [](const SpringLink& link) { return link.damping > 0; });
    plan.branched = network.has_branches();
    make_slots(network, time_step, plan);
    if (network.has_volume_energy()) add_cells(network, plan);
    for (const std::int32_t node : plan.nodes) {
        if (node < 0) continue;
        m_local_of[std::size_t(node)] = -1;
        m_active[std::size_t(node)] = 0;
    }
}

/// Assigns local numbers; frozen nodes are sorted by number, which forms rows too.
void SweepPlanner::number(const SpringNetwork& network, SweepPlan& plan) {
    for (std::size_t l = 0; l < plan.nodes.size(); ++l)
        if (plan.nodes[l] >= 0) m_local_of[std::size_t(plan.nodes[l])] = std::int32_t(l);
    m_frozen.clear();
    const auto look_at = [&](std::int32_t node) {
        std::int32_t& local = m_local_of[std::size_t(node)];
        if (local != -1) return;
        local = 0;
        m_frozen.push_back(node);
    };
    plan.is_active.assign(plan.nodes.size(), 0);
    for (std::int32_t l = kPack; l < plan.active_end; ++l) {
        const std::int32_t node = plan.nodes[std::size_t(l)];
        if (node < 0 || !m_active[std::size_t(node)]) continue;
        plan.is_active[std::size_t(l)] = 1;
        for (const auto& neighbour : network.neighbours(node)) look_at(neighbour.node);
        if (!network.has_volume_energy()) continue;
        for (const std::int32_t c : network.cells_of(node)) {
            const SpringCell& cell = network.cells()[std::size_t(c)];
            for (int n = 0; n < cell.node_count; ++n) look_at(cell.nodes[std::size_t(n)]);
        }
    }
    std::sort(m_frozen.begin(), m_frozen.end());
    for (const std::int32_t node : m_frozen) {
        m_local_of[std::size_t(node)] = std::int32_t(plan.nodes.size());
        plan.nodes.push_back(node);
    }
    plan.nodes.insert(plan.nodes.end(), kPack, -1);
    while (plan.nodes.size() % kPack) plan.nodes.push_back(-1);
    plan.is_active.resize(plan.nodes.size(), 0);
}

void SweepPlanner::find_cells(const SpringNetwork& network, const SweepPlan& plan) {
    constexpr std::int32_t kFound = 0;
    for (auto& cells : m_cells) cells.clear();
    for (std::int32_t l = kPack; l < plan.active_end; ++l) {
        if (!plan.is_active[std::size_t(l)]) continue;
        for (const std::int32_t c : network.cells_of(plan.nodes[std::size_t(l)])) {
            const SpringCell& cell = network.cells()[std::size_t(c)];
            if (network.is_cell_cut(std::size_t(c)) || cell.bulk == 0) continue;
            if (m_cell_of[std::size_t(c)] >= 0) continue;
            m_cell_of[std::size_t(c)] = kFound;
            m_cells[cell.node_count == 8].push_back(c);
        }
    }
}

void SweepPlanner::add_cell_packs(const SpringNetwork& network, std::span<const std::int32_t> cells,
                                  std::int32_t node_count, SweepPlan& plan) {
    const auto rest = [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; };
    for (std::size_t n = 0; n < cells.size(); n += kPack) {
        const std::size_t first = plan.cell_nodes.size(), value = plan.cell_values.size();
        plan.cell_packs.push_back({std::int32_t(first), node_count});
        plan.cell_nodes.resize(first + std::size_t(kPack * node_count), 0);
        plan.cell_values.resize(value + kPack, 0);
        plan.cell_values.resize(value + 2 * kPack, 1);
        for (std::size_t lane = 0; lane < kPack && n + lane < cells.size(); ++lane) {
            const auto c = std::size_t(cells[n + lane]);
            const SpringCell& cell = network.cells()[c];
            m_cell_of[c] = std::int32_t(first + lane);
            for (std::size_t k = 0; k < std::size_t(node_count); ++k)
                plan.cell_nodes[first + kPack * k + lane] = m_local_of[std::size_t(cell.nodes[k])];
            plan.cell_values[value + lane] = cell.bulk;
            plan.cell_values[value + kPack + lane] = cell_volume(cell, rest);
        }
    }
}

void SweepPlanner::add_cells(const SpringNetwork& network, SweepPlan& plan) {
    m_cell_of.assign(network.cells().size(), -1);
    plan.first_corner.assign(1, 0);
    find_cells(network, plan);
    add_cell_packs(network, m_cells[0], 4, plan);
    add_cell_packs(network, m_cells[1], 8, plan);
    for (std::int32_t l = kPack; l < plan.active_end; ++l) {
        const std::int32_t node = plan.nodes[std::size_t(l)];
        if (plan.is_active[std::size_t(l)])
            for (const std::int32_t c : network.cells_of(node)) {
                if (m_cell_of[std::size_t(c)] < 0) continue;
                const auto& nodes = network.cells()[std::size_t(c)].nodes;
                const auto corner = std::find(nodes.begin(), nodes.end(), node);
                plan.corners.push_back(m_cell_of[std::size_t(c)] +
                                       kPack * std::int32_t(corner - nodes.begin()));
            }
        plan.first_corner.push_back(std::int32_t(plan.corners.size()));
    }
}

}  // namespace pliant
