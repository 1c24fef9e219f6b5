// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Common part of all methods: they request costs at points given by logarithms. It records the
// effort and the best point so far. Costs of several points are computed concurrently and recorded
// in their order, so that results are independent of threads.

#pragma once

#include "base/stopwatch.h"
#include "fit/problem_impl.h"

namespace pliant {

class Search {
  public:
    using Point = std::vector<double>;  ///< logarithms of the values

    Search(const FitProblem& problem, const TaskArena& arena);

    const FitProblem::Impl& problem() const { return m_problem; }
    const TaskArena& arena() const { return m_arena; }
    std::size_t size() const { return m_low.size(); }
    double low(std::size_t g) const { return m_low[g]; }
    double high(std::size_t g) const { return m_high[g]; }
    Point start() const;
    Point within_bounds(Point point) const;
    Point values(const Point& point) const;

    /// Cost at a point; infinite if the network has no equilibrium.
    double cost(const Point& point);
    std::vector<double> costs(const std::vector<Point>& points);
    void count(std::int64_t evaluations) { m_result.evaluations += evaluations; }

    const Point& best() const { return m_best; }
    FitResult& result() { return m_result; }
    /// Evaluates the point with all cases, and stops the clock.
    Result<FitResult> finish(const Point& point);

  private:
    void note(const Point& point, double cost);

    const FitProblem& m_face;
    const FitProblem::Impl& m_problem;
    const TaskArena& m_arena;
    Point m_low, m_high, m_best;
    FitResult m_result;
    Stopwatch m_watch;
};

Result<FitResult> search_gauss_newton(Search& search, const GaussNewton& settings);
Result<FitResult> search_annealing(Search& search, const Annealing& settings);

}  // namespace pliant
