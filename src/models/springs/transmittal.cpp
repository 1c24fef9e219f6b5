// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/transmittal.h"

#include <algorithm>
#include <atomic>

#include "base/errors.h"

namespace pliant {
namespace {

constexpr std::size_t kKeptPlans = 32;
constexpr std::int32_t kPacksPerTask = 64;

constexpr std::int64_t kCellPacksPerTask = 16, kNodesPerTask = 512, kNodesPerCopy = 16384;

}  // namespace

Transmittal::Transmittal(const SpringSettings& settings, double time_step)
    : m_time_step(time_step),
      m_kernel(settings.vectors ? vector_sweep() : plain_sweep()),
      m_volume_kernel(settings.vectors ? vector_volume_sweep() : plain_volume_sweep()) {}

Transmittal::Kept& Transmittal::find_plan(const SpringNetwork& network, std::int32_t depth,
                                          bool everything) {
    for (const auto& kept : m_kept)
        if (kept->depth == depth && kept->sources == m_sources) return *kept;
    // The present plan is in m_kept, and must stay unchanged until this one is complete.
    m_kept.reserve(kKeptPlans);
    if (!m_spare) m_spare = std::make_unique<Kept>();
    Kept& kept = *m_spare;
    kept.sources = m_sources;
    kept.depth = depth;
    if (everything) {
        m_order.nodes.clear();
        for (std::int32_t n = 0; n < network.node_count(); ++n)
            if (!network.nodes()[std::size_t(n)].fixed) m_order.nodes.push_back(n);
    } else {
        m_search.run(network, m_sources, depth, m_order);
    }
    m_planner.plan(network, m_order.nodes, m_time_step, kept.plan);
    if (m_kept.size() < kKeptPlans) {
        m_kept.push_back(std::move(m_spare));
        return kept;
    }
    m_spare.swap(m_kept[m_oldest]);
    m_oldest = (m_oldest + 1) % kKeptPlans;
    return kept;
}

/// Reserves the memory for all writes of a touch.
void Transmittal::reserve(const SpringState& state, const SweepPlan& plan) {
    const std::size_t count = plan.local_count();
    for (Three* three : {&m_x, &m_before, &m_two_before, &m_load, &m_force})
        for (AlignedArray& array : *three) array.reserve(count);
    m_keep.reserve(count);
    m_push.reserve(count);
    m_branch.reserve(plan.slot_links.size());
    m_other_branch.reserve(plan.slot_links.size());
    m_corner_force.reserve(4 * plan.cell_nodes.size());
    m_seen.reserve(plan.cell_packs.empty() ? 0 : 4 * count);
    m_loaded.reserve(state.loaded.size());
    m_held.reserve(state.held.size());
    m_contact.reserve(state.loaded.size() + state.held.size());
    m_left.reserve(std::size_t(plan.active_end));
    m_reached.resize(state.x[0].size(), 0);
}

void Transmittal::touch(const SpringNetwork& network, SpringState& state, std::int32_t depth,
                        bool everything) {
    if (m_plan && m_plan->depth == depth && m_loaded == state.loaded && m_held == state.held) {
        renew_contact(network, state);
        return;
    }
    m_sources.clear();
    if (!everything) {
        m_sources.assign(state.loaded.begin(), state.loaded.end());
        m_sources.insert(m_sources.end(), state.held.begin(), state.held.end());
    }
    Kept* next = nullptr;
    try {
        next = &find_plan(network, depth, everything);
        reserve(state, next->plan);
    } catch (...) {
        m_search = {};  // state kept between calls is invalid now
        m_planner = {};
        throw;
    }
    leave(state);
    m_loaded = state.loaded;
    m_held = state.held;
    m_plan = next;
    enter(network, state);
    const SweepPlan& plan = m_plan->plan;
    for (std::size_t l = 0; l < plan.local_count(); ++l)
        if (plan.is_active[l]) m_reached[std::size_t(plan.nodes[l])] = 1;
    for (const std::int32_t node : m_left)
        if (!m_reached[std::size_t(node)])
            for (int c = 0; c < 3; ++c)
                state.before[c][std::size_t(node)] = state.x[c][std::size_t(node)];
    for (std::size_t l = 0; l < plan.local_count(); ++l)
        if (plan.is_active[l]) m_reached[std::size_t(plan.nodes[l])] = 0;
}

void Transmittal::leave(SpringState& state) noexcept {
    m_left.clear();
    if (!m_plan) return;
    give_back(state);
    for (std::int32_t l = kPack; l < m_plan->plan.active_end; ++l)
        if (m_plan->plan.is_active[std::size_t(l)])
            m_left.push_back(m_plan->plan.nodes[std::size_t(l)]);
    m_plan = nullptr;
}

void Transmittal::set_node(const SpringNetwork& network, const SpringState& state,
                           std::size_t local) {
    const std::int32_t node = m_plan->plan.nodes[local];
    const auto n = std::size_t(std::max(node, 0));
    const bool active = m_plan->plan.is_active[local] != 0;
    for (int c = 0; c < 3; ++c) {
        m_x[c][local] = node < 0 ? 0 : state.x[c][n];
        m_before[c][local] = active ? state.before[c][n] : m_x[c][local];
        m_two_before[c][local] = m_before[c][local];
        m_load[c][local] = active ? state.load[c][n] : 0;
        m_force[c][local] = m_load[c][local];
    }
    m_keep[local] = m_push[local] = 0;
    if (!active || !state.moves(network, node)) return;
    const SpringNode& properties = network.nodes()[n];
    const double inertia = properties.mass / (m_time_step * m_time_step);
    const double drag = properties.damping / (2 * m_time_step);
    m_push[local] = 1 / (inertia + drag);
    m_keep[local] = (inertia - drag) * m_push[local];
}

void Transmittal::enter(const SpringNetwork& network, const SpringState& state) {
    const std::size_t count = m_plan->plan.local_count();
    for (Three* three : {&m_x, &m_before, &m_two_before, &m_load, &m_force})
        for (AlignedArray& array : *three) array.resize(count);
    m_keep.resize(count);
    m_push.resize(count);
    const std::vector<std::int32_t>& slot_links = m_plan->plan.slot_links;
    m_branch.resize(slot_links.size());
    m_other_branch.resize(slot_links.size());
    for (std::size_t s = 0; s < slot_links.size(); ++s)
        m_branch[s] = slot_links[s] < 0 ? 0 : state.branch[std::size_t(slot_links[s])];
    m_corner_force.resize(4 * m_plan->plan.cell_nodes.size());
    m_seen.assign(m_plan->plan.cell_packs.empty() ? 0 : 4 * count, 0);
    m_contact.clear();
    for (std::size_t local = 0; local < count; ++local) {
        set_node(network, state, local);
        const std::int32_t node = m_plan->plan.nodes[local];
        if (m_plan->plan.is_active[local] && state.is_touched[std::size_t(node)])
            m_contact.push_back(local);
    }
}

/// Updates loads and positions for an unchanged set of nodes in contact.
void Transmittal::renew_contact(const SpringNetwork& network, const SpringState& state) {
    for (const std::size_t local : m_contact) {
        const std::int32_t node = m_plan->plan.nodes[local];
        const auto n = std::size_t(node);
        for (int c = 0; c < 3; ++c) {
            m_load[c][local] = m_force[c][local] = state.load[c][n];
            if (!state.moves(network, node))
                m_x[c][local] = m_before[c][local] = m_two_before[c][local] = state.x[c][n];
        }
    }
}

void Transmittal::give_back(SpringState& state) const {
    if (!m_plan) return;
    for (std::int32_t l = kPack; l < m_plan->plan.active_end; ++l) {
        if (!m_plan->plan.is_active[std::size_t(l)]) continue;
        const std::int32_t node = m_plan->plan.nodes[std::size_t(l)];
        for (int c = 0; c < 3; ++c) {
            state.x[c][std::size_t(node)] = m_x[std::size_t(c)][std::size_t(l)];
            state.before[c][std::size_t(node)] = m_before[std::size_t(c)][std::size_t(l)];
        }
    }
    const std::vector<std::int32_t>& slot_links = m_plan->plan.slot_links;
    for (std::size_t s = 0; s < slot_links.size(); ++s)
        if (slot_links[s] >= 0) state.branch[std::size_t(slot_links[s])] = m_branch[s];
}

void Transmittal::forget(SpringState& state) noexcept {
    leave(state);
    m_kept.clear();
    m_oldest = 0;
}

SweepArrays Transmittal::arrays() {
    SweepArrays arrays{};
    for (std::size_t c = 0; c < 3; ++c) {
        arrays.x[c] = m_x[c].data();
        arrays.before[c] = m_before[c].data();
        // The next step overwrites the positions of two steps before.
        arrays.next[c] = m_two_before[c].data();
        arrays.force[c] = m_force[c].data();
    }
    arrays.keep = m_keep.data();
    arrays.push = m_push.data();
    arrays.branch = m_branch.data();
    arrays.next_branch = m_other_branch.data();
    return arrays;
}

bool Transmittal::sweep_packs(const TaskArena& arena, double farthest) {
    const SweepPlan& plan = m_plan->plan;
    const SweepArrays a = arrays();
    const auto packs = std::int64_t(plan.packs.size());
    std::atomic<bool> all_near{true};
    const struct {
        const SweepPlan& plan;
        SweepKernel kernel;
        const SweepArrays& a;
        double farthest2;
        std::atomic<bool>& all_near;
    } job{plan, m_kernel, a, farthest * farthest, all_near};
    if (packs <= kPacksPerTask && plan.cell_packs.empty())
        return m_kernel(plan, a, 0, packs, job.farthest2);
    arena.for_each(packs, kPacksPerTask, [&job](std::int64_t begin, std::int64_t end) {
        if (!job.kernel(job.plan, job.a, begin, end, job.farthest2))
            job.all_near.store(false, std::memory_order_relaxed);
    });
    return all_near.load();
}

bool Transmittal::step(const TaskArena& arena, double farthest) {
    if (!m_plan) return true;
    if (!m_plan->plan.cell_packs.empty()) add_volume_forces(arena);
    const bool all_near = sweep_packs(arena, farthest);
    m_before.swap(m_two_before);
    m_x.swap(m_before);
    m_branch.swap(m_other_branch);
    return all_near;
}

void Transmittal::take_back() {
    m_x.swap(m_before);
    m_before.swap(m_two_before);
    m_branch.swap(m_other_branch);
}

// Forces of the cells' volume energy.

void Transmittal::add_volume_forces(const TaskArena& arena) {
    const SweepPlan& plan = m_plan->plan;
    const struct {
        double* to;
        const double* from[3];
    } copy{m_seen.data(), {m_x[0].data(), m_x[1].data(), m_x[2].data()}};
    arena.for_each(std::int64_t(plan.local_count()), kNodesPerCopy,
                   [&copy](std::int64_t begin, std::int64_t end) {
                       for (std::int64_t l = begin; l < end; ++l)
                           for (int c = 0; c < 3; ++c) copy.to[4 * l + c] = copy.from[c][l];
                   });
    const struct {
        const SweepPlan& plan;
        VolumeKernel kernel;
        VolumeArrays arrays;
    } job{plan,
          m_volume_kernel,
          {m_seen.data(),
           m_corner_force.data(),
           {m_load[0].data(), m_load[1].data(), m_load[2].data()},
           {m_force[0].data(), m_force[1].data(), m_force[2].data()}}};
    arena.for_each(std::int64_t(plan.cell_packs.size()), kCellPacksPerTask,
                   [&job](std::int64_t begin, std::int64_t end) {
                       job.kernel.cells(job.plan, job.arrays, begin, end);
                   });
    arena.for_each(plan.active_end - kPack, kNodesPerTask,
                   [&job](std::int64_t begin, std::int64_t end) {
                       job.kernel.nodes(job.plan, job.arrays, kPack + begin, kPack + end);
                   });
}

Status check_sources(const SpringNetwork& network, std::span<const std::int32_t> sources,
                     const char* argument) {
    const auto complain = [&](const std::string& text) {
        return Error{ErrorCode::InvalidArgument, std::string(argument) + ": " + text};
    };
    for (const std::int32_t node : sources) {
        if (node < 0 || node >= network.node_count())
            return complain("expected nodes below " + std::to_string(network.node_count()) +
                            ", found " + std::to_string(node));
        if (network.nodes()[std::size_t(node)].fixed)
            return complain("expected nodes that can move, found node " + std::to_string(node) +
                            ", which is fixed");
    }
    return Ok{};
}

Status check_depth(std::int32_t depth) {
    if (depth < 0)
        return about("depth", ErrorCode::InvalidArgument,
                     "expected 0 layers or more, found " + std::to_string(depth));
    return Ok{};
}

void OrderSearch::run(const SpringNetwork& network, std::span<const std::int32_t> sources,
                      std::int32_t depth, TransmittalOrder& order) {
    if (m_seen.size() != std::size_t(network.node_count()) || ++m_turn == 0) {
        m_seen.assign(std::size_t(network.node_count()), 0);
        m_turn = 1;
    }
    std::vector<std::int32_t>& nodes = order.nodes;
    nodes.clear();
    order.layers.assign(1, 0);
    const auto visit = [&](std::int32_t node) {
        std::uint32_t& seen = m_seen[std::size_t(node)];
        if (seen == m_turn || network.nodes()[std::size_t(node)].fixed) return;
        seen = m_turn;
        nodes.push_back(node);
    };
    for (const std::int32_t node : sources) visit(node);
    for (std::int32_t layer = 0;; ++layer) {
        const auto begin = std::size_t(order.layers.back());
        const std::size_t end = nodes.size();
        if (begin == end) break;  // all nodes have been reached
        order.layers.push_back(std::int32_t(end));
        if (layer == depth) break;
        for (std::size_t n = begin; n < end; ++n)
            for (const auto& neighbour : network.neighbours(nodes[n])) visit(neighbour.node);
    }
}

Result<TransmittalOrder> transmittal_order(const SpringNetwork& network,
                                           std::span<const std::int32_t> sources,
                                           std::int32_t depth) noexcept {
    return attempt([&]() -> Result<TransmittalOrder> {
        if (const Status status = check_sources(network, sources, "sources"); !status.ok())
            return status.error();
        if (const Status status = check_depth(depth); !status.ok()) return status.error();
        TransmittalOrder order;
        OrderSearch().run(network, sources, depth, order);
        return order;
    });
}

}  // namespace pliant
