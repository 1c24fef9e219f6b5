// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Checks of a problem, and the distance of a network from its reference.

#include <algorithm>
#include <cmath>
#include <string>

#include "fit/problem_impl.h"

namespace pliant {
namespace {

Error bad_problem(const std::string& text) {
    return {ErrorCode::InvalidArgument, "fit: " + text};
}

Status check_members(const FitGroup& group, std::span<const std::int32_t> members, const char* what,
                     std::vector<std::uint8_t>& taken) {
    for (const std::int32_t m : members) {
        if (m < 0 || std::size_t(m) >= taken.size())
            return bad_problem("group " + group.name + ": expected " + what + "s below " +
                               std::to_string(taken.size()) + ", found " + std::to_string(m));
        if (taken[std::size_t(m)]++)
            return bad_problem("group " + group.name + ": expected each " + what +
                               " in one group, found " + what + " " + std::to_string(m) + " again");
    }
    return Ok{};
}

Status check_groups(const SpringParts& parts, std::span<const FitGroup> groups) {
    if (groups.empty()) return bad_problem("expected one or more groups, found none");
    std::vector<std::uint8_t> links(parts.links.size(), 0), cells(parts.cells.size(), 0),
        nodes(parts.nodes.size(), 0);
    for (const FitGroup& g : groups) {
        if (g.links.empty() && g.cells.empty() && g.nodes.empty())
            return bad_problem("group " + g.name + ": expected links, cells or nodes, found none");
        const bool ordered = g.low > 0 && g.low <= g.start && g.start <= g.high;
        if (!ordered || !std::isfinite(g.high))
            return bad_problem("group " + g.name + ": expected 0 < low <= start <= high, found " +
                               std::to_string(g.low) + ", " + std::to_string(g.start) + " and " +
                               std::to_string(g.high));
        for (const Status& status :
             {check_members(g, g.links, "link", links), check_members(g, g.cells, "cell", cells),
              check_members(g, g.nodes, "node", nodes)})
            if (!status.ok()) return status.error();
    }
    return Ok{};
}

Status check_case(const SpringParts& parts, const FitCase& c,
                  const std::vector<std::uint8_t>& held) {
    const auto here = [&](const std::string& text) {
        return bad_problem("case " + c.name + ": " + text);
    };
    const std::size_t count = parts.nodes.size();
    if (c.target.empty() == c.points.empty())
        return here(c.points.empty() ? "expected a target or points, found neither"
                                     : "expected a target or points, found both");
    if (c.points.empty() && c.target.size() != count)
        return here("expected a target for each of " + std::to_string(count) + " nodes, found " +
                    std::to_string(c.target.size()));
    if (c.forces.size() != c.nodes.size())
        return here("expected a force for each of " + std::to_string(c.nodes.size()) +
                    " nodes, found " + std::to_string(c.forces.size()));
    if (c.nodes.empty()) return here("expected loaded nodes, found none");
    if (!(std::isfinite(c.weight) && c.weight > 0))
        return here("expected a weight above 0, found " + std::to_string(c.weight));
    std::vector<std::uint8_t> loaded(count, 0);
    for (std::size_t n = 0; n < c.nodes.size(); ++n) {
        const std::int32_t node = c.nodes[n];
        if (node < 0 || std::size_t(node) >= count)
            return here("expected loads on nodes below " + std::to_string(count) + ", found " +
                        std::to_string(node));
        if (held[std::size_t(node)])
            return here("expected loads on free nodes, found node " + std::to_string(node) +
                        ", which is held");
        if (loaded[std::size_t(node)]++)
            return here("expected each loaded node once, found node " + std::to_string(node) +
                        " again");
        if (!is_finite(c.forces[n]))
            return here("expected three numbers as the force on node " + std::to_string(node));
    }
    for (std::size_t n = 0; n < c.target.size(); ++n)
        if (!is_finite(c.target[n]))
            return here("expected three numbers as the target of node " + std::to_string(n));
    for (std::size_t p = 0; p < c.points.size(); ++p) {
        const FitPointTarget& point = c.points[p];
        bool is_good = is_finite(point.displacement);
        for (std::size_t k = 0; k < 4; ++k)
            is_good &= point.nodes[k] >= 0 && std::size_t(point.nodes[k]) < count &&
                       std::isfinite(point.weights[k]);
        if (!is_good)
            return here("expected nodes below " + std::to_string(count) +
                        " and finite numbers at point " + std::to_string(p));
    }
    return Ok{};
}

/// The targets of a case as points.
std::vector<FitPointTarget> points_of(const FitCase& c) {
    if (!c.points.empty()) return c.points;
    std::vector<FitPointTarget> points;
    for (std::size_t n = 0; n < c.target.size(); ++n)
        points.push_back({.nodes = {std::int32_t(n), 0, 0, 0}, .displacement = c.target[n]});
    return points;
}

Status check_settings(const FitSettings& s) {
    if (!(std::isfinite(s.spring_length) && s.spring_length >= 0))
        return bad_problem("spring_length: expected a length of 0 or more, found " +
                           std::to_string(s.spring_length));
    if (s.motion == FitMotion::Run && !(std::isfinite(s.duration) && s.duration > 0))
        return bad_problem("duration: expected a time above 0, found " +
                           std::to_string(s.duration));
    return Ok{};
}

using A = Annealing;
using F = FitSettings;
using G = GaussNewton;

constexpr Setting<F> kFit[] = {
    setting<&F::motion>({.name = "motion",
                         .choices = "linear|equilibrium|run",
                         .text = "how the network's displacement under a load is computed"}),
    setting<&F::cost>({.name = "cost",
                       .choices = "distances|squares",
                       .text = "sum over cases and nodes of the distances to the reference"}),
    setting<&F::spring_length>({.name = "spring_length",
                                .range = {.low = 0},
                                .text = "errors are in percent of this length; 0: the shortest "
                                        "link"}),
    setting<&F::duration>({.name = "duration",
                           .range = {.low = 0},
                           .above_low = true,
                           .text = "simulated time of a run"}),
};

constexpr Setting<G> kGaussNewton[] = {
    setting<&G::max_steps>({.name = "max_steps", .range = {.low = 1}, .text = "steps"}),
    setting<&G::tolerance>({.name = "tolerance",
                            .range = {.low = 0},
                            .above_low = true,
                            .text = "stops when all logarithms change by less"}),
};

constexpr Setting<A> kAnnealing[] = {
    setting<&A::start_temperature>({.name = "start_temperature",
                                    .range = {.low = 0},
                                    .text = "in the unit of the cost; 0: four of five uphill moves "
                                            "are accepted"}),
    setting<&A::end_temperature>({.name = "end_temperature",
                                  .range = {.low = 0},
                                  .text = "below the start's; 0: a thousandth of it"}),
    setting<&A::cooling>({.name = "cooling",
                          .range = {.low = 0},
                          .text = "β; 0: such that the evaluations lead from start to end"}),
    setting<&A::neighbourhood>({.name = "neighbourhood",
                                .range = {0, 1},
                                .above_low = true,
                                .text = "largest move of a logarithm, in parts of its range"}),
    setting<&A::by_turns>(
        {.name = "by_turns", .text = "a neighbour differs in one value, by turns, not in all"}),
    setting<&A::evaluations>(
        {.name = "evaluations", .range = {.low = 1}, .text = "of the cost, at most"}),
    setting<&A::preparation>(
        {.name = "preparation", .range = {.low = 1}, .text = "random moves beforehand"}),
    setting<&A::best_seen>(
        {.name = "best_seen", .text = "the answer is the best point instead of the last one"}),
};

}  // namespace

FitProblem::FitProblem(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
FitProblem::~FitProblem() = default;
FitProblem::FitProblem(FitProblem&&) noexcept = default;
FitProblem& FitProblem::operator=(FitProblem&&) noexcept = default;

std::span<const FitGroup> FitProblem::groups() const {
    return m_impl->groups;
}
std::span<const FitCase> FitProblem::cases() const {
    return m_impl->cases;
}
const FitSettings& FitProblem::settings() const {
    return m_impl->settings;
}
double FitProblem::spring_length() const {
    return m_impl->spring_length;
}
SpringParts FitProblem::parts_at(std::span<const double> values) const {
    return m_impl->parts_at(values);
}

Result<FitProblem> FitProblem::create(SpringParts parts, std::vector<FitGroup> groups,
                                      std::vector<FitCase> cases, const FitSettings& settings) {
    if (const Status status = check_settings(settings); !status.ok()) return status.error();
    const auto network = SpringNetwork::create(parts);
    if (!network.ok()) return network.error();
    if (const Status status = check_groups(parts, groups); !status.ok()) return status.error();
    auto impl = std::make_unique<Impl>();
    impl->spring_length = settings.spring_length;
    double shortest = 0;
    for (std::size_t l = 0; l < parts.links.size(); ++l) {
        SpringLink& link = parts.links[l];
        const double apart =
            norm(parts.nodes[std::size_t(link.a)].rest - parts.nodes[std::size_t(link.b)].rest);
        link.rest_length = network->links()[l].rest_length;
        if (settings.motion == FitMotion::Linear &&
            !(std::abs(link.rest_length - apart) <= 1e-9 * apart))
            return bad_problem("link " + std::to_string(l) +
                               ": expected its nodes' distance as its rest length, found " +
                               std::to_string(link.rest_length) +
                               "; a linear motion starts at rest");
        if (apart > 0 && (shortest == 0 || apart < shortest)) shortest = apart;
    }
    if (impl->spring_length == 0) impl->spring_length = shortest;
    if (!(impl->spring_length > 0)) return bad_problem("expected links, found none");
    for (const FitCase& c : cases) {
        std::vector<std::uint8_t> held(parts.nodes.size(), 0);
        for (std::size_t n = 0; n < held.size(); ++n) held[n] = parts.nodes[n].fixed;
        for (const std::int32_t n : c.held) {
            if (n < 0 || std::size_t(n) >= held.size())
                return bad_problem("case " + c.name + ": expected held nodes below " +
                                   std::to_string(held.size()) + ", found " + std::to_string(n));
            held[std::size_t(n)] = 1;
        }
        if (const Status status = check_case(parts, c, held); !status.ok()) return status.error();
        const auto known = std::find(impl->held.begin(), impl->held.end(), held);
        impl->held_of.push_back(std::size_t(known - impl->held.begin()));
        if (known == impl->held.end()) impl->held.push_back(std::move(held));
        impl->targets.push_back(points_of(c));
    }
    if (std::all_of(cases.begin(), cases.end(), [](const FitCase& c) { return c.held_out; }))
        return bad_problem("expected one or more cases that aren't held out, found none");
    if (settings.motion == FitMotion::Linear)
        for (const auto& held : impl->held) impl->linear.emplace_back(parts, groups, held);
    impl->parts = std::move(parts);
    impl->groups = std::move(groups);
    impl->cases = std::move(cases);
    impl->settings = settings;
    return FitProblem(std::move(impl));
}

Result<FitPoint> FitProblem::evaluate(std::span<const double> values) const {
    const auto moved = m_impl->move(values, true);
    if (!moved.ok()) return moved.error();
    FitPoint point;
    point.cost = m_impl->cost_of(*moved);
    const double percent = 100 / m_impl->spring_length;
    for (std::size_t c = 0; c < m_impl->cases.size(); ++c) {
        const FitCase& fit_case = m_impl->cases[c];
        FitCaseErrors errors{.name = fit_case.name, .held_out = fit_case.held_out};
        const auto& targets = m_impl->targets[c];
        for (const FitPointTarget& target : targets) {
            const double off = percent * norm(moved_at((*moved)[c], target) - target.displacement);
            const double still = percent * norm(target.displacement);
            errors.average_percent += off / double(targets.size());
            errors.still_average_percent += still / double(targets.size());
            errors.largest_percent = std::max(errors.largest_percent, off);
            errors.still_largest_percent = std::max(errors.still_largest_percent, still);
        }
        point.cases.push_back(std::move(errors));
    }
    return point;
}

Result<std::vector<Vec3d>> FitProblem::displacements(std::span<const double> values,
                                                     std::size_t fit_case) const {
    if (fit_case >= m_impl->cases.size())
        return bad_problem("displacements: expected a case below " +
                           std::to_string(m_impl->cases.size()) + ", found " +
                           std::to_string(fit_case));
    auto moved = m_impl->move(values, true);
    if (!moved.ok()) return moved.error();
    return std::move((*moved)[fit_case]);
}

Result<std::vector<Vec3d>> FitProblem::residuals(std::span<const double> values,
                                                 std::size_t fit_case) const {
    auto moved = displacements(values, fit_case);
    if (!moved.ok()) return moved.error();
    std::vector<Vec3d> residuals;
    for (const FitPointTarget& target : m_impl->targets[fit_case])
        residuals.push_back(moved_at(*moved, target) - target.displacement);
    return residuals;
}

double FitProblem::Impl::cost_of(const Displacements& displacements) const {
    double cost = 0;
    for (std::size_t c = 0; c < cases.size(); ++c) {
        if (cases[c].held_out) continue;
        double sum = 0;
        for (const FitPointTarget& target : targets[c]) {
            const Vec3d off = moved_at(displacements[c], target) - target.displacement;
            sum += settings.cost == FitCost::Distances ? norm(off) : dot(off, off);
        }
        cost += cases[c].weight * sum;
    }
    return cost;
}

// The tables of settings of a fit and its methods.

SettingRows<FitSettings> fit_rows() noexcept {
    return kFit;
}
SettingRows<GaussNewton> gauss_newton_rows() noexcept {
    return kGaussNewton;
}
SettingRows<Annealing> annealing_rows() noexcept {
    return kAnnealing;
}

}  // namespace pliant
