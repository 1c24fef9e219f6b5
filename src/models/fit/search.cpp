// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fit/search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace pliant {
namespace {

constexpr double kOnBound = 1e-4;  ///< tolerance of a logarithm

}  // namespace

Search::Search(const FitProblem& problem, const TaskArena& arena)
    : m_face(problem), m_problem(problem.impl()), m_arena(arena) {
    for (const FitGroup& group : m_problem.groups) {
        m_low.push_back(std::log(group.low));
        m_high.push_back(std::log(group.high));
    }
}

Search::Point Search::start() const {
    Point point;
    for (const FitGroup& group : m_problem.groups) point.push_back(std::log(group.start));
    return point;
}

Search::Point Search::within_bounds(Point point) const {
    for (std::size_t g = 0; g < point.size(); ++g)
        point[g] = std::clamp(point[g], m_low[g], m_high[g]);
    return point;
}

Search::Point Search::values(const Point& point) const {
    Point values(point);
    for (double& v : values) v = std::exp(v);
    return values;
}

double Search::cost(const Point& point) {
    return costs({point})[0];
}

std::vector<double> Search::costs(const std::vector<Point>& points) {
    std::vector<double> costs(points.size());
    m_arena.for_each(std::int64_t(points.size()), 1, [&](std::int64_t begin, std::int64_t end) {
        for (auto p = std::size_t(begin); p < std::size_t(end); ++p) {
            const auto moved =
                m_problem.move(values(points[p]), false, [&] { return m_arena.gives_up(); });
            const double cost = moved.ok() ? m_problem.cost_of(*moved) : 0;
            const bool known = moved.ok() && std::isfinite(cost);
            costs[p] = known ? cost : std::numeric_limits<double>::infinity();
        }
    });
    for (std::size_t p = 0; p < points.size(); ++p) note(points[p], costs[p]);
    return costs;
}

void Search::note(const Point& point, double cost) {
    ++m_result.evaluations;
    if (!std::isfinite(cost)) {
        ++m_result.refused;
        return;
    }
    if (!m_result.trace.empty() && cost >= m_result.trace.back().cost) return;
    m_best = point;
    m_result.trace.push_back({m_result.evaluations, cost, m_watch.s()});
}

Result<FitResult> Search::finish(const Point& point) {
    m_result.seconds = m_watch.s();
    m_result.values = values(point);
    for (std::size_t g = 0; g < point.size(); ++g)
        m_result.at_bound.push_back(point[g] <= m_low[g] + kOnBound    ? FitBound::Low
                                    : point[g] >= m_high[g] - kOnBound ? FitBound::High
                                                                       : FitBound::None);
    auto judged = m_face.evaluate(m_result.values);
    if (!judged.ok()) return judged.error();
    m_result.at = std::move(*judged);
    auto directions = fit_directions(m_face, m_result.values, m_arena);
    if (!directions.ok()) return directions.error();
    m_result.directions = std::move(*directions);
    return std::move(m_result);
}

namespace {

Result<FitResult> search_nothing(Search& search, const GivenValues& given) {
    if (const Status status = search.problem().check_values(given.values); !status.ok())
        return status.error();
    Search::Point point = given.values;
    for (double& v : point) v = std::log(v);
    search.cost(point);
    return search.finish(point);
}

}  // namespace

Result<FitResult> fit(const FitProblem& problem, const FitMethod& method, const TaskArena& arena) {
    Search search(problem, arena);
    if (const auto* given = std::get_if<GivenValues>(&method))
        return search_nothing(search, *given);
    if (const auto* newton = std::get_if<GaussNewton>(&method))
        return search_gauss_newton(search, *newton);
    return search_annealing(search, *std::get_if<Annealing>(&method));
}

}  // namespace pliant
