// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Confidence intervals from the linearised covariance. With J the derivatives of the measured
// displacements by the logarithms, and w the weights of the cases,
//
//   cov = c σ² A⁻¹ B A⁻¹,   A = Σ w JᵀJ,   B = Σ w² JᵀJ
//
// c = 1 for a sum of squares. For a sum of distances c = 3π/8: with ψ(r) = r/|r| and noise in three
// dimensions, E[ψψᵀ] = 1/3 and E[∂ψ/∂r] = 2/3 · √(2/π)/σ; c is the quotient of the first and the
// square of the second.

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "base/small_matrix.h"
#include "fit/problem_impl.h"

namespace pliant {
namespace {

constexpr double kTwoSided95 = 1.959964;  ///< quantile of the normal distribution
/// A value has no interval if more than this share of its unit vector (squared) lies in directions
/// that aren't identifiable.
constexpr double kMaxLostShare = 0.01;

/// Σ weight(case) · JᵀJ over the fitted cases.
template <class Weight>
SquareMatrix information(const FitProblem::Impl& problem, const FitProblem::Impl::Derivatives& d,
                         const Weight& weight) {
    const std::size_t size = problem.groups.size();
    SquareMatrix sum(size, std::vector<double>(size, 0));
    for (std::size_t c = 0; c < problem.cases.size(); ++c) {
        if (problem.cases[c].held_out) continue;
        const double w = weight(problem.cases[c].weight);
        for (const FitPointTarget& target : problem.targets[c])
            for (std::size_t g = 0; g < size; ++g)
                for (std::size_t h = 0; h < size; ++h)
                    sum[g][h] +=
                        w * dot(moved_at(d.by[g][c], target), moved_at(d.by[h][c], target));
    }
    return sum;
}

}  // namespace

Result<std::vector<FitInterval>> fit_intervals(const FitProblem& problem,
                                               std::span<const double> values, double noise,
                                               const TaskArena& arena) {
    if (!(std::isfinite(noise) && noise > 0))
        return Error{ErrorCode::InvalidArgument,
                     "noise: expected a number above 0, found " + std::to_string(noise)};
    const FitProblem::Impl& impl = problem.impl();
    const auto directions = fit_directions(problem, values, arena);
    if (!directions.ok()) return directions.error();
    const auto derivatives = impl.derivatives(values, arena);
    if (!derivatives.ok()) return derivatives.error();
    const std::size_t size = values.size();
    const SquareMatrix a = information(impl, *derivatives, [](double w) { return w; });
    const SquareMatrix b = information(impl, *derivatives, [](double w) { return w * w; });
    const double factor = impl.settings.cost == FitCost::Distances ? 3 * std::numbers::pi / 8 : 1;
    // The directions are eigenvectors of A: A⁻¹ is a sum over the identifiable ones.
    SquareMatrix inverse(size, std::vector<double>(size, 0));
    std::vector<double> lost(size, 0);
    for (const FitDirection& d : *directions) {
        const std::vector<double>& v = d.direction;
        double curvature = 0;
        for (std::size_t g = 0; g < size; ++g)
            for (std::size_t h = 0; h < size; ++h) curvature += v[g] * a[g][h] * v[h];
        for (std::size_t g = 0; g < size; ++g) {
            if (d.influence < kMinInfluence)
                lost[g] += v[g] * v[g];
            else
                for (std::size_t h = 0; h < size; ++h) inverse[g][h] += v[g] * v[h] / curvature;
        }
    }
    std::vector<FitInterval> intervals;
    for (std::size_t g = 0; g < size; ++g) {
        if (lost[g] > kMaxLostShare) {
            intervals.push_back({0, std::numeric_limits<double>::infinity(), false});
            continue;
        }
        double variance = 0;
        for (std::size_t h = 0; h < size; ++h)
            for (std::size_t k = 0; k < size; ++k)
                variance += inverse[g][h] * b[h][k] * inverse[k][g];
        const double reach = kTwoSided95 * noise * std::sqrt(factor * variance);
        intervals.push_back({values[g] * std::exp(-reach), values[g] * std::exp(reach)});
    }
    return intervals;
}

}  // namespace pliant
