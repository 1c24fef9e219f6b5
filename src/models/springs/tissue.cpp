// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/springs.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/hash.h"
#include "base/text.h"
#include "springs/stability.h"
#include "springs/tissue_impl.h"

namespace pliant {
namespace {

Status check_settings(const SpringNetwork& network, const SpringSettings& s) {
    if (Status status = check(s, spring_solver_rows()); !status.ok()) return status;
    if (network.has_branches() && s.solver == SpringSolver::ImplicitEuler)
        return invalid("solver: expected ForceTransmittal or Explicit for Maxwell branches");
    return Ok{};
}

/// Returns the time step to use, or an error about the requested one.
Result<double> choose_time_step(const SpringNetwork& network, const SpringSettings& s) {
    const double longest = network.stable_time_step();
    const bool any = s.solver == SpringSolver::ImplicitEuler;
    if (s.time_step == 0) {
        if (!std::isfinite(longest))
            return invalid(
                "time_step: expected one, since the network has no stiffness to tell it by");
        return 0.9 * longest;
    }
    if (!any && s.time_step > longest)
        return invalid("time_step: expected at most " + short_text(longest) +
                       ", the longest that is sure to be stable, found " + short_text(s.time_step));
    return s.time_step;
}

/// Doesn't allocate on success. @param marks  [node]; all 0 between calls
Status check_nodes(const SpringNetwork& network, std::span<const std::int32_t> nodes,
                   const char* what, std::vector<std::uint8_t>& marks) {
    if (const Status status = check_sources(network, nodes, what); !status.ok())
        return status.error();
    std::int32_t twice = -1;  // the lowest duplicate
    for (const std::int32_t n : nodes)
        if (std::exchange(marks[std::size_t(n)], std::uint8_t(1)) && (twice < 0 || n < twice))
            twice = n;
    for (const std::int32_t n : nodes) marks[std::size_t(n)] = 0;
    if (twice >= 0)
        return invalid(std::string(what) + ": expected each node once, found node " +
                       std::to_string(twice) + " again");
    return Ok{};
}

}  // namespace

SettingRows<SpringSettings> spring_solver_rows() noexcept {
    using S = SpringSettings;
    static constexpr Setting<S> kRows[] = {
        setting<&S::solver>({.name = "solver",
                             .choices = "force_transmittal|explicit|implicit_euler",
                             .text = "method of a step"}),
        setting<&S::depth>({.name = "depth",
                            .unit = "layers",
                            .range = {.low = 0},
                            .text = "layers beyond the contact that move"}),
        setting<&S::time_step>({.name = "time_step",
                                .range = {.low = 0},
                                .text = "duration of a step; 0: 90 % of the stability bound"}),
        setting<&S::vectors>({.name = "vectors",
                              .text = "vector instructions; the scalar code gives the same bits"}),
        setting<&S::solve_tolerance>({.name = "solve_tolerance",
                                      .range = {0, 1},
                                      .above_low = true,
                                      .below_high = true,
                                      .text = "relative residual of implicit Euler"}),
        setting<&S::solve_iterations>({.name = "solve_iterations",
                                       .range = {.low = 1},
                                       .text = "of implicit Euler, at most"}),
        setting<&S::assembled>(
            {.name = "assembled",
             .text = "implicit Euler with an assembled matrix and a coarse space"}),
    };
    return kRows;
}

SpringTissue::SpringTissue(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
SpringTissue::~SpringTissue() = default;
SpringTissue::SpringTissue(SpringTissue&&) noexcept = default;
SpringTissue& SpringTissue::operator=(SpringTissue&&) noexcept = default;

Result<SpringTissue> SpringTissue::create(SpringNetwork network,
                                          const SpringSettings& settings) noexcept {
    return attempt([&]() -> Result<SpringTissue> {
        if (const Status status = check_settings(network, settings); !status.ok())
            return status.error();
        const auto time_step = choose_time_step(network, settings);
        if (!time_step.ok()) return time_step.error();
        auto impl = std::make_unique<Impl>(std::move(network), settings, *time_step);
        set_to_rest(impl->network, impl->state);
        relax_branches(impl->network, impl->state, *time_step);
        // Loads and held nodes can then always be replaced without allocation.
        const auto count = std::size_t(impl->network.node_count());
        impl->state.loaded.reserve(count);
        impl->state.held.reserve(count);
        impl->marks.assign(count, 0);
        return SpringTissue(std::move(impl));
    });
}

const SpringNetwork& SpringTissue::network() const {
    return m_impl->network;
}
double SpringTissue::time_step() const {
    return m_impl->time_step;
}

Status SpringTissue::load(std::span<const std::int32_t> nodes,
                          std::span<const Vec3d> forces) noexcept {
    return attempt([&] { return m_impl->load(nodes, forces); });
}

Status SpringTissue::Impl::load(std::span<const std::int32_t> nodes,
                                std::span<const Vec3d> forces) {
    if (nodes.size() != forces.size())
        return invalid("load: expected a force for each of " + std::to_string(nodes.size()) +
                       " nodes, found " + std::to_string(forces.size()));
    if (const Status status = check_nodes(network, nodes, "load", marks); !status.ok())
        return status.error();
    for (std::size_t n = 0; n < forces.size(); ++n)
        if (!is_finite(forces[n]))
            return invalid("load: expected three numbers as the force on node " +
                           std::to_string(nodes[n]));
    for (const std::int32_t n : state.loaded)
        for (int c = 0; c < 3; ++c) state.load[c][std::size_t(n)] = 0;
    state.loaded.assign(nodes.begin(), nodes.end());
    for (std::size_t n = 0; n < nodes.size(); ++n)
        for (int c = 0; c < 3; ++c) state.load[c][std::size_t(nodes[n])] = forces[n][c];
    renew_touched(state);
    return Ok{};
}

Status SpringTissue::hold(std::span<const std::int32_t> nodes) noexcept {
    return attempt([&] { return m_impl->hold(nodes); });
}

Status SpringTissue::Impl::hold(std::span<const std::int32_t> nodes) {
    if (const Status status = check_nodes(network, nodes, "hold", marks); !status.ok())
        return status.error();
    current();
    for (const std::int32_t n : state.held) state.is_held[std::size_t(n)] = 0;
    state.held.assign(nodes.begin(), nodes.end());
    for (const std::int32_t n : state.held) {
        state.is_held[std::size_t(n)] = 1;
        state.put_before(n, state.position(n));
    }
    renew_touched(state);
    return Ok{};
}

Status SpringTissue::move_held(std::span<const Vec3d> positions) noexcept {
    SpringState& state = m_impl->current();
    Status status = attempt([&]() -> Status {
        if (positions.size() != state.held.size())
            return invalid("move_held: expected a position for each of " +
                           std::to_string(state.held.size()) + " held nodes, found " +
                           std::to_string(positions.size()));
        for (const Vec3d position : positions)
            if (!is_finite(position))
                return invalid("move_held: expected positions of three numbers");
        return Ok{};
    });
    if (!status.ok()) return status;
    for (std::size_t n = 0; n < positions.size(); ++n) {
        state.put(state.held[n], positions[n]);
        state.put_before(state.held[n], positions[n]);
    }
    return Ok{};
}

Status SpringTissue::shift_held(Vec3d shift) noexcept {
    if (!is_finite(shift))
        return attempt([]() -> Status { return invalid("shift_held: expected three numbers"); });
    SpringState& state = m_impl->current();
    for (const std::int32_t n : state.held) {
        state.put(n, state.position(n) + shift);
        state.put_before(n, state.position(n));
    }
    return Ok{};
}

Status SpringTissue::set_depth(std::int32_t depth) noexcept {
    if (Status status = attempt([&] { return check_depth(depth); }); !status.ok()) return status;
    m_impl->settings.depth = depth;
    return Ok{};
}

Vec3d SpringTissue::position(std::int32_t node) const {
    PLIANT_ASSERT(node >= 0 && node < m_impl->network.node_count());
    return m_impl->current().position(node);
}
Vec3d SpringTissue::velocity(std::int32_t node) const {
    PLIANT_ASSERT(node >= 0 && node < m_impl->network.node_count());
    const SpringState& state = m_impl->current();
    return (1 / m_impl->time_step) * (state.position(node) - state.position_before(node));
}
Vec3d SpringTissue::displacement(std::int32_t node) const {
    return position(node) - m_impl->network.nodes()[std::size_t(node)].rest;
}
std::vector<Vec3d> SpringTissue::displacements() const {
    std::vector<Vec3d> all(std::size_t(m_impl->network.node_count()));
    for (std::size_t n = 0; n < all.size(); ++n) all[n] = displacement(std::int32_t(n));
    return all;
}

Status SpringTissue::set_state(std::int32_t node, Vec3d position, Vec3d velocity) noexcept {
    Status status = attempt([&]() -> Status {
        const std::int32_t nodes[] = {node};
        if (Status s = check_sources(m_impl->network, nodes, "set_state"); !s.ok()) return s;
        if (!is_finite(position) || !is_finite(velocity))
            return invalid("set_state: expected three numbers each");
        return Ok{};
    });
    if (!status.ok()) return status;
    SpringState& state = m_impl->edited();
    state.put(node, position);
    state.put_before(node, position - m_impl->time_step * velocity);
    return Ok{};
}

Result<SpringCut> SpringTissue::cut_links(std::span<const std::int32_t> links) noexcept {
    auto cut = m_impl->network.cut_links(links);
    if (cut.ok()) m_impl->forget_network();
    return cut;
}
Result<SpringCut> SpringTissue::cut_cells(std::span<const std::int32_t> cells) noexcept {
    auto cut = m_impl->network.cut_cells(cells);
    if (cut.ok()) m_impl->forget_network();
    return cut;
}

std::uint64_t SpringTissue::hash() const noexcept {
    const SpringState& state = m_impl->current();
    Hash64 hash;
    for (const auto& axis : state.x) hash.add(std::span<const double>(axis));
    return hash.value();
}

void SpringTissue::reset() noexcept {
    SpringState& state = m_impl->edited();
    set_to_rest(m_impl->network, state);
    relax_branches(m_impl->network, state, m_impl->time_step);
}

}  // namespace pliant
