// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacements of a network for given values, and their derivatives.

#include <cmath>
#include <string>

#include "fit/problem_impl.h"

namespace pliant {
namespace {

/// Step of a logarithm in central differences: the third derivative causes errors of 1e-8, and the
/// equilibrium's tolerance is divided by the step.
constexpr double kDifference = 1e-4;
constexpr double kEquilibrium = 1e-10;

Error loose() {
    return {ErrorCode::InvalidArgument,
            "fit: values: expected a network that its loads leave in place, found one with nodes "
            "that move without a force"};
}

}  // namespace

Status FitProblem::Impl::check_values(std::span<const double> values) const {
    if (values.size() != groups.size())
        return Error{ErrorCode::InvalidArgument,
                     "fit: values: expected one for each of " + std::to_string(groups.size()) +
                         " groups, found " + std::to_string(values.size())};
    for (std::size_t g = 0; g < groups.size(); ++g)
        if (!(std::isfinite(values[g]) && values[g] > 0))
            return Error{ErrorCode::InvalidArgument,
                         "fit: values: expected numbers above 0, found " +
                             std::to_string(values[g]) + " for group " + groups[g].name};
    return Ok{};
}

SpringParts FitProblem::Impl::parts_at(std::span<const double> values) const {
    SpringParts made = parts;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        for (const std::int32_t l : groups[g].links)
            made.links[std::size_t(l)].stiffness *= values[g];
        for (const std::int32_t c : groups[g].cells) made.cells[std::size_t(c)].bulk *= values[g];
        for (const std::int32_t n : groups[g].nodes)
            made.nodes[std::size_t(n)].damping *= values[g];
    }
    return made;
}

std::vector<Vec3d> FitProblem::Impl::force_of(const FitCase& c) const {
    std::vector<Vec3d> force(parts.nodes.size(), Vec3d{0, 0, 0});
    for (std::size_t n = 0; n < c.nodes.size(); ++n) force[std::size_t(c.nodes[n])] = c.forces[n];
    return force;
}

Result<Displacements> FitProblem::Impl::move(std::span<const double> values, bool all,
                                             const std::function<bool()>& give_up) const {
    if (const Status status = check_values(values); !status.ok()) return status.error();
    return settings.motion == FitMotion::Linear ? move_linear(values, all)
                                                : move_tissue(values, all, give_up);
}

Result<Displacements> FitProblem::Impl::move_linear(std::span<const double> values,
                                                    bool all) const {
    Displacements moved(cases.size());
    for (std::size_t set = 0; set < held.size(); ++set) {
        std::shared_ptr<const LinearNetwork::Factor> factor;
        for (std::size_t c = 0; c < cases.size(); ++c) {
            if (held_of[c] != set || (cases[c].held_out && !all)) continue;
            if (!factor) factor = linear[set].factor(values);
            if (!factor) return loose();
            moved[c] = linear[set].solve(*factor, force_of(cases[c]));
        }
    }
    return moved;
}

Result<Displacements> FitProblem::Impl::move_tissue(std::span<const double> values, bool all,
                                                    const std::function<bool()>& give_up) const {
    const bool runs = settings.motion == FitMotion::Run;
    SpringSettings how = settings.run;
    if (!runs) how = {.solver = SpringSolver::Explicit};
    const SpringParts made = parts_at(values);
    const TaskArena one_thread(HostJobs{.run = {}, .give_up = give_up});
    Displacements moved(cases.size());
    for (std::size_t c = 0; c < cases.size(); ++c) {
        if (cases[c].held_out && !all) continue;
        SpringParts of_case = made;
        for (std::size_t n = 0; n < of_case.nodes.size(); ++n)
            of_case.nodes[n].fixed = held[held_of[c]][n];
        auto network = SpringNetwork::create(std::move(of_case));
        if (!network.ok()) return network.error();
        auto tissue = SpringTissue::create(std::move(*network), how);
        if (!tissue.ok()) return tissue.error();
        if (const Status status = tissue->load(cases[c].nodes, cases[c].forces); !status.ok())
            return status.error();
        if (runs) {
            const double steps = std::ceil(settings.duration / tissue->time_step());
            if (!(steps < 2e9))
                return Error{ErrorCode::LimitExceeded,
                             "fit: duration: expected fewer than 2000000000 steps"};
            const auto report = tissue->step(std::int32_t(steps), one_thread);
            if (!report.ok()) return report.error();
        } else if (const Status status = tissue->find_equilibrium(kEquilibrium, give_up);
                   !status.ok()) {
            return status.error();
        }
        moved[c] = tissue->displacements();
    }
    return moved;
}

Result<FitProblem::Impl::Derivatives> FitProblem::Impl::derivatives(std::span<const double> values,
                                                                    const TaskArena& arena) const {
    if (const Status status = check_values(values); !status.ok()) return status.error();
    if (settings.motion != FitMotion::Linear) return differences(values, arena);
    Derivatives result{.at = Displacements(cases.size()),
                       .by = std::vector(groups.size(), Displacements(cases.size())),
                       .evaluations = 1};
    std::vector<std::shared_ptr<const LinearNetwork::Factor>> factors(held.size());
    std::vector<std::size_t> fitted;
    for (std::size_t c = 0; c < cases.size(); ++c) {
        if (cases[c].held_out) continue;
        auto& factor = factors[held_of[c]];
        if (!factor) factor = linear[held_of[c]].factor(values);
        if (!factor) return loose();
        result.at[c] = linear[held_of[c]].solve(*factor, force_of(cases[c]));
        fitted.push_back(c);
    }
    const auto work = std::int64_t(fitted.size() * groups.size());
    arena.for_each(work, 1, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t w = begin; w < end; ++w) {
            const std::size_t g = std::size_t(w) % groups.size();
            const std::size_t c = fitted[std::size_t(w) / groups.size()];
            const LinearNetwork& network = linear[held_of[c]];
            std::vector<Vec3d> right = network.multiply(g, result.at[c]);
            for (Vec3d& f : right) f = -values[g] * f;
            result.by[g][c] = network.solve(*factors[held_of[c]], right);
        }
    });
    return result;
}

Result<FitProblem::Impl::Derivatives> FitProblem::Impl::differences(std::span<const double> values,
                                                                    const TaskArena& arena) const {
    const std::size_t points = 2 * groups.size() + 1;
    std::vector<Result<Displacements>> moved(points, Displacements{});
    arena.for_each(std::int64_t(points), 1, [&](std::int64_t begin, std::int64_t end) {
        for (auto p = std::size_t(begin); p < std::size_t(end); ++p) {
            std::vector<double> there(values.begin(), values.end());
            if (p > 0) there[(p - 1) / 2] *= std::exp(p % 2 == 1 ? kDifference : -kDifference);
            moved[p] = move(there, false, [&] { return arena.gives_up(); });
        }
    });
    for (const auto& one : moved)
        if (!one.ok()) return one.error();
    Derivatives result{.at = *moved[0],
                       .by = std::vector(groups.size(), Displacements(cases.size())),
                       .evaluations = std::int64_t(points)};
    for (std::size_t g = 0; g < groups.size(); ++g)
        for (std::size_t c = 0; c < cases.size(); ++c) {
            if (cases[c].held_out) continue;
            auto& by = result.by[g][c];
            by.resize(parts.nodes.size());
            for (std::size_t n = 0; n < by.size(); ++n)
                by[n] = (1 / (2 * kDifference)) *
                        ((*moved[2 * g + 1])[c][n] - (*moved[2 * g + 2])[c][n]);
        }
    return result;
}

}  // namespace pliant
