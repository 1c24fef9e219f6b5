// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Interface of a problem to the methods: costs, displacements and their derivatives.

#pragma once

#include "fit/linear_network.h"

namespace pliant {

using Displacements = std::vector<std::vector<Vec3d>>;  ///< [case][node]; empty: left out

/// Displacement at a point.
inline Vec3d moved_at(std::span<const Vec3d> moved, const FitPointTarget& point) {
    Vec3d sum = point.weights[0] * moved[std::size_t(point.nodes[0])];
    for (std::size_t k = 1; k < 4; ++k)
        if (point.weights[k] != 0)
            sum = sum + point.weights[k] * moved[std::size_t(point.nodes[k])];
    return sum;
}

struct FitProblem::Impl {
    SpringParts parts;
    std::vector<FitGroup> groups;
    std::vector<FitCase> cases;
    FitSettings settings;
    double spring_length = 0;
    /// Distinct sets of nodes that are fixed in some case.
    std::vector<std::vector<std::uint8_t>> held;
    std::vector<std::size_t> held_of;                  ///< [case]
    std::vector<std::vector<FitPointTarget>> targets;  ///< [case]: its target or its points
    std::vector<LinearNetwork> linear;                 ///< [set], for linear motion

    Status check_values(std::span<const double> values) const;
    SpringParts parts_at(std::span<const double> values) const;
    std::vector<Vec3d> force_of(const FitCase& fit_case) const;

    /// @param all  includes cases that are held out
    /// @param give_up  polled now and then; true: LimitExceeded
    Result<Displacements> move(std::span<const double> values, bool all,
                               const std::function<bool()>& give_up = {}) const;
    double cost_of(const Displacements& displacements) const;

    /// Derivatives of the fitted cases' displacements with respect to the logarithms of the values.
    struct Derivatives {
        Displacements at;
        std::vector<Displacements> by;  ///< [group][case][node]
        std::int64_t evaluations = 0;
    };
    Result<Derivatives> derivatives(std::span<const double> values, const TaskArena& arena) const;

  private:
    Result<Displacements> move_linear(std::span<const double> values, bool all) const;
    Result<Displacements> move_tissue(std::span<const double> values, bool all,
                                      const std::function<bool()>& give_up) const;
    Result<Derivatives> differences(std::span<const double> values, const TaskArena& arena) const;
};

}  // namespace pliant
