// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/transmittal.h"

#include <algorithm>
#include <atomic>

namespace pliant {
namespace {

constexpr std::size_t kKeptPlans = 32;
constexpr std::int32_t kPacksPerTask = 64;

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

}  // namespace pliant
