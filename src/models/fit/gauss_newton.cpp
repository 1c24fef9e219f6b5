// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Gauss-Newton: with r the distances from the reference and J = ∂u/∂ln p, a step s solves JᵀW J s =
// −JᵀW r. W contains the cases' weights. For a sum of distances (not squares), each node's weight
// is divided by |r| of the last step; the fixed points of this iteration are the minima of that sum
// [Weiszfeld1937].

#include <algorithm>
#include <cmath>
#include <string>

#include "base/small_matrix.h"
#include "fit/search.h"

namespace pliant {
namespace {

constexpr int kHalvings = 30;
/// Lower clamp of |r|, in spring lengths: otherwise a node that fits by chance would dominate.
constexpr double kNearest = 1e-9;

struct Normal {
    SquareMatrix matrix;
    std::vector<double> right;
};

/// @param distances  uses weights 1/|r|
Normal normal_equations(const FitProblem::Impl& problem, const FitProblem::Impl::Derivatives& d,
                        bool distances) {
    const std::size_t size = problem.groups.size();
    Normal normal{SquareMatrix(size, std::vector<double>(size, 0)), std::vector<double>(size, 0)};
    for (std::size_t c = 0; c < problem.cases.size(); ++c) {
        const FitCase& fit_case = problem.cases[c];
        if (fit_case.held_out) continue;
        for (const FitPointTarget& target : problem.targets[c]) {
            const Vec3d r = moved_at(d.at[c], target) - target.displacement;
            double weight = fit_case.weight;
            if (distances) weight /= std::max(norm(r), kNearest * problem.spring_length);
            for (std::size_t g = 0; g < size; ++g) {
                const Vec3d by = weight * moved_at(d.by[g][c], target);
                normal.right[g] -= dot(by, r);
                for (std::size_t h = 0; h <= g; ++h)
                    normal.matrix[g][h] += dot(by, moved_at(d.by[h][c], target));
            }
        }
    }
    for (std::size_t g = 0; g < size; ++g)
        for (std::size_t h = 0; h < g; ++h) normal.matrix[h][g] = normal.matrix[g][h];
    return normal;
}

std::vector<FitDirection> directions_of(const FitProblem::Impl& problem,
                                        const FitProblem::Impl::Derivatives& d) {
    double moved = 0;
    for (std::size_t c = 0; c < problem.cases.size(); ++c)
        if (!problem.cases[c].held_out)
            for (const FitPointTarget& target : problem.targets[c])
                moved += problem.cases[c].weight * dot(target.displacement, target.displacement);
    const auto eigen = symmetric_eigen(normal_equations(problem, d, false).matrix);
    std::vector<FitDirection> directions;
    for (std::size_t n = 0; n < eigen.values.size(); ++n)
        directions.push_back({eigen.vectors[n], std::sqrt(std::max(0.0, eigen.values[n]) / moved)});
    return directions;
}

double dot_of(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t n = 0; n < a.size(); ++n) sum += a[n] * b[n];
    return sum;
}

/// Step in the span of the identifiable directions.
std::vector<double> step_of(const Normal& normal, const std::vector<FitDirection>& directions) {
    std::vector<std::vector<double>> basis;
    for (const FitDirection& d : directions)
        if (d.influence >= kMinInfluence) basis.push_back(d.direction);
    std::vector<double> step(normal.right.size(), 0);
    if (basis.empty()) return step;
    SquareMatrix inner(basis.size(), std::vector<double>(basis.size(), 0));
    for (std::size_t a = 0; a < basis.size(); ++a)
        for (std::size_t b = 0; b < basis.size(); ++b)
            for (std::size_t g = 0; g < step.size(); ++g)
                inner[a][b] += basis[a][g] * dot_of(normal.matrix[g], basis[b]);
    const auto eigen = symmetric_eigen(inner);
    for (std::size_t e = 0; e < basis.size(); ++e) {
        double along = 0;
        for (std::size_t a = 0; a < basis.size(); ++a)
            along += eigen.vectors[e][a] * dot_of(basis[a], normal.right);
        along /= eigen.values[e];
        for (std::size_t a = 0; a < basis.size(); ++a)
            for (std::size_t g = 0; g < step.size(); ++g)
                step[g] += along * eigen.vectors[e][a] * basis[a][g];
    }
    return step;
}

double longest(const std::vector<double>& step) {
    double most = 0;
    for (const double s : step) most = std::max(most, std::abs(s));
    return most;
}

}  // namespace

Result<FitResult> search_gauss_newton(Search& search, const GaussNewton& settings) {
    const auto bad = [](const std::string& text) {
        return Error{ErrorCode::InvalidArgument, "GaussNewton: " + text};
    };
    if (const Status s = check(settings, gauss_newton_rows()); !s.ok())
        return bad(s.error().message);
    const FitProblem::Impl& problem = search.problem();
    const bool distances = problem.settings.cost == FitCost::Distances;
    Search::Point point = search.start();
    double cost = search.cost(point);
    for (int turn = 0; turn < settings.max_steps; ++turn) {
        const auto derivatives = problem.derivatives(search.values(point), search.arena());
        if (!derivatives.ok()) return derivatives.error();
        search.count(derivatives->evaluations);
        const std::vector<double> step = step_of(normal_equations(problem, *derivatives, distances),
                                                 directions_of(problem, *derivatives));
        double part = std::min(1.0, 2 / std::max(longest(step), 1e-300));
        double moved = 0;
        for (int halving = 0; halving < kHalvings; ++halving, part /= 2) {
            Search::Point next(point);
            for (std::size_t g = 0; g < next.size(); ++g) next[g] += part * step[g];
            next = search.within_bounds(std::move(next));
            std::vector<double> change(next);
            for (std::size_t g = 0; g < next.size(); ++g) change[g] -= point[g];
            if (longest(change) < settings.tolerance) break;
            const double there = search.cost(next);
            if (there >= cost) continue;
            moved = longest(change);
            point = std::move(next);
            cost = there;
            break;
        }
        if (moved < settings.tolerance) break;
    }
    return search.finish(point);
}

Result<std::vector<FitDirection>> fit_directions(const FitProblem& problem,
                                                 std::span<const double> values,
                                                 const TaskArena& arena) {
    const auto derivatives = problem.impl().derivatives(values, arena);
    if (!derivatives.ok()) return derivatives.error();
    return directions_of(problem.impl(), *derivatives);
}

}  // namespace pliant
