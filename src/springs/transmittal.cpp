// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/transmittal.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "springs/cell_volume.h"

namespace pliant {
namespace {

constexpr std::size_t kKeptPlans = 32;
constexpr std::int64_t kPacksPerTask = 64, kCellsPerTask = 128;

}  // namespace

Transmittal::Transmittal(const SpringSettings& settings, double time_step)
    : m_settings(settings),
      m_time_step(time_step),
      m_kernel(settings.vectors ? vector_sweep() : plain_sweep()) {}

Transmittal::Kept& Transmittal::find_plan(const SpringNetwork& network, std::int32_t depth,
                                          bool everything) {
    for (const auto& kept : m_kept)
        if (kept->depth == depth && kept->sources == m_sources) return *kept;
    if (m_kept.size() < kKeptPlans) m_kept.push_back(std::make_unique<Kept>());
    Kept& kept = *m_kept[m_kept.size() < kKeptPlans ? m_kept.size() - 1 : m_oldest];
    if (m_kept.size() == kKeptPlans) m_oldest = (m_oldest + 1) % kKeptPlans;
    kept.sources = m_sources;
    kept.depth = depth;
    if (everything) {
        m_order.nodes.clear();
        for (std::int32_t n = 0; n < network.node_count(); ++n)
            if (!network.nodes()[std::size_t(n)].fixed) m_order.nodes.push_back(n);
        m_order.layers = {0, std::int32_t(m_order.nodes.size())};
    } else {
        m_search.run(network, m_sources, depth, m_order);
    }
    if (m_settings.seen == SeenPositions::NewNodes && !everything)
        m_planner.plan_in_order(network, m_order, m_time_step, kept.plan);
    else
        m_planner.plan(network, m_order, everything || m_settings.seen == SeenPositions::Old,
                       m_time_step, kept.plan);
    return kept;
}

void Transmittal::touch(const SpringNetwork& network, SpringState& state, std::int32_t depth,
                        bool everything) {
    if (m_plan && m_plan->depth == depth && m_loaded == state.loaded && m_held == state.held) {
        renew_contact(network, state);
        return;
    }
    leave(state);
    m_loaded = state.loaded;
    m_held = state.held;
    m_sources.clear();
    if (!everything) {
        m_sources.assign(m_loaded.begin(), m_loaded.end());
        m_sources.insert(m_sources.end(), m_held.begin(), m_held.end());
    }
    m_plan = &find_plan(network, depth, everything);
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

void Transmittal::leave(SpringState& state) {
    m_left.clear();
    m_reached.resize(state.x[0].size(), 0);
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
    m_corner_force.resize(8 * m_plan->plan.cells.size());
    m_contact.clear();
    for (std::size_t local = 0; local < count; ++local) {
        set_node(network, state, local);
        const std::int32_t node = m_plan->plan.nodes[local];
        if (m_plan->plan.is_active[local] && state.is_touched[std::size_t(node)])
            m_contact.push_back(local);
    }
}

/// The same nodes are in contact, with other loads or in other places.
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
}

void Transmittal::forget(SpringState& state) {
    leave(state);
    m_kept.clear();
    m_oldest = 0;
}

SweepArrays Transmittal::arrays() {
    SweepArrays arrays{};
    for (std::size_t c = 0; c < 3; ++c) {
        arrays.x[c] = m_x[c].data();
        arrays.before[c] = m_before[c].data();
        // Two steps before is what the next step overwrites.
        arrays.next[c] = m_two_before[c].data();
        arrays.force[c] = m_force[c].data();
    }
    arrays.keep = m_keep.data();
    arrays.push = m_push.data();
    return arrays;
}

bool Transmittal::sweep_group(const SweepGroup& group, const TaskArena& arena, double farthest) {
    const SweepArrays a = arrays();
    const std::int64_t count = group.end_pack - group.begin_pack;
    std::atomic<bool> all_near{true};
    const struct {
        const Transmittal& own;
        const SweepArrays& a;
        const SweepGroup& group;
        double farthest2;
        std::atomic<bool>& all_near;
    } job{*this, a, group, farthest * farthest, all_near};
    arena.for_each(count, kPacksPerTask, [&job](std::int64_t begin, std::int64_t end) {
        if (!job.own.m_kernel(job.own.m_plan->plan, job.a, job.group.begin_pack + begin,
                              job.group.begin_pack + end, job.farthest2))
            job.all_near.store(false, std::memory_order_relaxed);
    });
    return all_near.load();
}

void Transmittal::add_volume_forces(std::size_t group, const TaskArena& arena) {
    const SweepPlan& plan = m_plan->plan;
    const auto first_cell = plan.first_group_cell[group];
    const auto place = [this](std::int32_t l) {
        const auto n = std::size_t(l);
        return Vec3d{m_x[0][n], m_x[1][n], m_x[2][n]};
    };
    const struct {
        Transmittal& own;
        const SweepPlan& plan;
        const decltype(place)& place_of;
        std::int32_t first;
    } job{*this, plan, place, first_cell};
    arena.for_each(
        plan.first_group_cell[group + 1] - first_cell, kCellsPerTask,
        [&job](std::int64_t begin, std::int64_t end) {
            for (std::int64_t i = begin; i < end; ++i) {
                const auto c = std::size_t(job.plan.group_cells[std::size_t(job.first + i)]);
                const SweepCell& cell = job.plan.cells[c];
                Vec3d* const force = job.own.m_corner_force.data() + 8 * c;
                const Vec3d origin = job.place_of(cell.cell.nodes[0]);
                double volume = 0;
                for (int n = 0; n < cell.cell.node_count; ++n) {
                    force[n] = volume_gradient(cell.cell, n, job.place_of);
                    volume += dot(job.place_of(cell.cell.nodes[std::size_t(n)]) - origin, force[n]);
                }
                const double pressure = cell.cell.bulk * (volume / 3 / cell.rest_volume - 1);
                for (int n = 0; n < cell.cell.node_count; ++n) force[n] = -pressure * force[n];
            }
        });
    const struct {
        Transmittal& own;
        const SweepPlan& plan;
        std::int64_t first;
    } gather{*this, plan, std::int64_t(plan.groups[group].begin_pack + 1) * kPack};
    arena.for_each(
        std::int64_t(plan.groups[group].end_pack - plan.groups[group].begin_pack) * kPack,
        kPacksPerTask * kPack, [&gather](std::int64_t begin, std::int64_t end) {
            for (std::int64_t l = gather.first + begin; l < gather.first + end; ++l) {
                const auto n = std::size_t(l);
                Vec3d sum{gather.own.m_load[0][n], gather.own.m_load[1][n],
                          gather.own.m_load[2][n]};
                for (std::int32_t k = gather.plan.first_corner[n - kPack];
                     k < gather.plan.first_corner[n - kPack + 1]; ++k) {
                    const CellCorner& corner = gather.plan.corners[std::size_t(k)];
                    sum = sum +
                          gather.own.m_corner_force[std::size_t(8 * corner.cell + corner.corner)];
                }
                for (std::size_t c = 0; c < 3; ++c) gather.own.m_force[c][n] = sum[int(c)];
            }
        });
}

bool Transmittal::sweep_in_order(double farthest) {
    const SweepPlan& plan = m_plan->plan;
    bool all_near = true;
    const auto place = [this](std::int32_t l) {
        const auto n = std::size_t(l);
        return Vec3d{m_x[0][n], m_x[1][n], m_x[2][n]};
    };
    for (std::int32_t pack = 0; pack < std::int32_t(plan.packs.size()); ++pack)
        for (int lane = 0; lane < kPack; ++lane) {
            const auto i = std::size_t((pack + 1) * kPack + lane);
            if (!plan.is_active[i]) continue;
            Vec3d sum{m_load[0][i], m_load[1][i], m_load[2][i]};
            const Vec3d here = place(std::int32_t(i));
            const Vec3d moved = here - Vec3d{m_before[0][i], m_before[1][i], m_before[2][i]};
            const PackSlots& slots = plan.packs[std::size_t(pack)];
            for (std::uint32_t s = slots.begin; s < slots.end; ++s) {
                const SweepSlot& slot = plan.slots[s];
                const double* block = plan.blocks.data() + slot.block * plan.block_size();
                if (block[lane] == 0 && (!plan.damped || block[2 * kPack + lane] == 0)) continue;
                const auto j = s < slots.rows_end
                                   ? std::size_t(std::int64_t(i) + slot.other)
                                   : std::size_t(plan.others[std::size_t(slot.other + lane)]);
                const Vec3d r = here - place(std::int32_t(j));
                const double length2 = dot(r, r);
                if (!(length2 > 0)) continue;
                double f = block[kPack + lane] / std::sqrt(length2) - block[lane];
                if (plan.damped)
                    f -= block[2 * kPack + lane] / length2 *
                         dot(r, moved - (place(std::int32_t(j)) -
                                         Vec3d{m_before[0][j], m_before[1][j], m_before[2][j]}));
                sum = sum + f * r;
            }
            if (!plan.first_corner.empty())
                for (std::int32_t k = plan.first_corner[i - kPack];
                     k < plan.first_corner[i - kPack + 1]; ++k) {
                    const CellCorner& corner = plan.corners[std::size_t(k)];
                    const SweepCell& cell = plan.cells[std::size_t(corner.cell)];
                    sum = sum - (cell.cell.bulk *
                                 (cell_volume(cell.cell, place) / cell.rest_volume - 1)) *
                                    volume_gradient(cell.cell, corner.corner, place);
                }
            const Vec3d move = m_push[i] * sum + m_keep[i] * moved;
            all_near &= dot(move, move) <= farthest * farthest;
            for (int c = 0; c < 3; ++c) {
                const auto axis = std::size_t(c);
                m_two_before[axis][i] = m_before[axis][i];
                m_before[axis][i] = m_x[axis][i];
                m_x[axis][i] += move[c];
            }
        }
    return all_near;
}

bool Transmittal::step(const TaskArena& arena, double farthest) {
    if (!m_plan) return true;
    const SweepPlan& plan = m_plan->plan;
    if (m_settings.seen == SeenPositions::NewNodes &&
        m_settings.solver == SpringSolver::ForceTransmittal)
        return sweep_in_order(farthest);
    bool all_near = true;
    if (plan.groups.size() == 1) {
        if (!plan.cells.empty()) add_volume_forces(0, arena);
        all_near = sweep_group(plan.groups[0], arena, farthest);
        m_before.swap(m_two_before);
        m_x.swap(m_before);
        return all_near;
    }
    for (std::size_t g = 0; g < plan.groups.size(); ++g) {
        if (!plan.cells.empty()) add_volume_forces(g, arena);
        all_near &= sweep_group(plan.groups[g], arena, farthest);
        const auto begin = std::ptrdiff_t(plan.groups[g].begin_pack + 1) * kPack;
        const auto end = std::ptrdiff_t(plan.groups[g].end_pack + 1) * kPack;
        for (std::size_t c = 0; c < 3; ++c) {
            std::swap_ranges(m_before[c].begin() + begin, m_before[c].begin() + end,
                             m_two_before[c].begin() + begin);
            std::swap_ranges(m_x[c].begin() + begin, m_x[c].begin() + end,
                             m_before[c].begin() + begin);
        }
    }
    return all_near;
}

void Transmittal::take_back() {
    for (std::size_t c = 0; c < 3; ++c) {
        m_x[c] = m_before[c];
        m_before[c] = m_two_before[c];
    }
}

}  // namespace pliant
