// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One step of each solver.

#include <algorithm>
#include <string>

#include "base/errors.h"
#include "base/text.h"
#include "springs/stability.h"
#include "springs/tissue_impl.h"

namespace pliant {

void SpringTissue::Impl::forget_network() noexcept {
    transmittal.forget(state);
    state_is_behind = false;
    assembled.forget();
}

Result<SpringStep> SpringTissue::Impl::step_explicit(std::int32_t count, const TaskArena& arena) {
    const bool everything = settings.solver == SpringSolver::Explicit;
    transmittal.touch(network, state, settings.depth, everything);
    state_is_behind = true;
    SpringStep report{.active_nodes = transmittal.active_nodes()};
    for (; report.steps < count; ++report.steps) {
        if (transmittal.step(arena, farthest)) continue;
        transmittal.take_back();
        current();
        try {
            return unstable();
        } catch (const std::bad_alloc&) {  // the earlier steps are done
            return Error{ErrorCode::InvalidArgument, "step: unstable"};
        }
    }
    return report;
}

/// Error about a step that was undone.
Error SpringTissue::Impl::unstable() {
    std::vector<Vec3d> positions(std::size_t(network.node_count()));
    for (std::size_t n = 0; n < positions.size(); ++n)
        positions[n] = state.position(std::int32_t(n));
    const double longest = pliant::stable_time_step(network, positions);
    if (longest < time_step)
        return {ErrorCode::InvalidArgument,
                "time_step: expected at most " + short_text(longest) +
                    ", the longest that is stable for the present shape, found " +
                    short_text(time_step)};
    return {ErrorCode::InvalidArgument,
            "step: a node moved by more than the longest link, " + short_text(farthest) +
                "; expected smaller loads, shifts or time steps than " + short_text(time_step)};
}

void SpringTissue::Impl::find_movable() {
    const auto count = std::size_t(network.node_count());
    movable.assign(count, 0);
    if (settings.solver == SpringSolver::ForceTransmittal) {
        std::vector<std::int32_t> sources = state.loaded;
        sources.insert(sources.end(), state.held.begin(), state.held.end());
        TransmittalOrder order;
        OrderSearch().run(network, sources, settings.depth, order);
        for (const std::int32_t n : order.nodes) movable[std::size_t(n)] = state.moves(network, n);
        return;
    }
    for (std::size_t n = 0; n < count; ++n) movable[n] = state.moves(network, std::int32_t(n));
}

/// (M/h² + D/h + C/h + K) v = (F + f)/h + M v/h²
void SpringTissue::Impl::step_once_implicit(SpringStep& report) {
    const double h = time_step;
    tangent.renew(network, state, movable, TangentKind::Positive, 1 / (h * h), 1 / h, 1 / h);
    for (std::size_t n = 0; n < velocity.size(); ++n) {
        const auto node = std::int32_t(n);
        velocity[n] = {0, 0, 0};
        right[n] = {0, 0, 0};
        if (!movable[n]) continue;
        velocity[n] = (1 / h) * (state.position(node) - state.position_before(node));
        right[n] = (1 / h) * (state.load_of(node) + static_force(network, state, node)) +
                   (network.nodes()[n].mass / (h * h)) * velocity[n];
    }
    report.iterations += tangent.solve(
        network, right, {settings.solve_tolerance, settings.solve_iterations}, velocity);
    for (std::size_t n = 0; n < velocity.size(); ++n) {
        const auto node = std::int32_t(n);
        if (!movable[n]) continue;
        const Vec3d now = state.position(node);
        state.put_before(node, now);
        state.put(node, now + h * velocity[n]);
    }
}

Result<SpringStep> SpringTissue::Impl::step_implicit(std::int32_t count) {
    find_movable();
    right.resize(movable.size());
    velocity.resize(movable.size());
    SpringStep report{.active_nodes = std::int32_t(std::count(movable.begin(), movable.end(), 1))};
    if (settings.assembled) assembled.prepare(network, time_step);
    for (; report.steps < count; ++report.steps)
        if (settings.assembled)
            report.iterations +=
                assembled.step(network, state, movable, time_step,
                               {settings.solve_tolerance, settings.solve_iterations});
        else
            step_once_implicit(report);
    return report;
}

Result<SpringStep> SpringTissue::step(std::int32_t count, const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<SpringStep> {
        if (count < 0)
            return Error{ErrorCode::InvalidArgument,
                         "step: expected 0 steps or more, found " + std::to_string(count)};
        return m_impl->is_explicit() ? m_impl->step_explicit(count, arena)
                                     : m_impl->step_implicit(count);
    });
}

}  // namespace pliant
