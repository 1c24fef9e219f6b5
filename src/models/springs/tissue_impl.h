// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// State of a SpringTissue.

#pragma once

#include <algorithm>

#include "springs/assembled_euler.h"
#include "springs/state.h"
#include "springs/tangent.h"
#include "springs/transmittal.h"

namespace pliant {

struct SpringTissue::Impl {
    Impl(SpringNetwork n, const SpringSettings& s, double step)
        : network(std::move(n)),
          settings(s),
          time_step(step),
          transmittal(s, step),
          assembled(s.vectors) {
        for (const SpringLink& link : network.links())
            farthest = std::max(farthest, link.rest_length);
    }

    bool is_explicit() const { return settings.solver != SpringSolver::ImplicitEuler; }
    /// The state, brought up to date.
    SpringState& current() noexcept {
        if (state_is_behind) transmittal.give_back(state);
        state_is_behind = false;
        return state;
    }
    /// The state for changes of nodes' positions.
    SpringState& edited() noexcept {
        transmittal.leave(state);
        state_is_behind = false;
        return state;
    }
    Status load(std::span<const std::int32_t> nodes, std::span<const Vec3d> forces);
    Status hold(std::span<const std::int32_t> nodes);
    Status find_equilibrium(double tolerance, const std::function<bool()>& give_up);
    Result<SpringReaction> reaction(std::span<const std::int32_t> nodes, ReactionLaw law);
    double static_energy();
    Error unstable();
    Result<SpringStep> step_explicit(std::int32_t count, const TaskArena& arena);
    Result<SpringStep> step_implicit(std::int32_t count);
    void step_once_implicit(SpringStep& report);
    bool find_relaxed_stiffness(std::span<const std::int32_t> nodes, TangentKind kind,
                                Mat3d& stiffness);
    /// Finds the nodes that steps move.
    void find_movable();
    void forget_network() noexcept;

    SpringNetwork network;
    SpringSettings settings;
    double time_step;
    double farthest = 0;  ///< longest rest length, the limit of a stable step's motion
    SpringState state;
    bool state_is_behind = false;
    Transmittal transmittal;
    Tangent tangent;
    AssembledEuler assembled;
    std::vector<std::uint8_t> movable;
    std::vector<std::uint8_t> marks;     ///< [node]; all 0 between calls
    std::vector<Vec3d> right, velocity;  ///< of the implicit solver
};

}  // namespace pliant
