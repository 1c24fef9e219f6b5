// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Creep of a network under a constant load, M ü + D u̇ + K u = F, by BDF2 with a first step of
// backward Euler: of second order, and free of the trapezoidal rule's ringing where masses are
// small. D = damping · M. A scan over the bounds finds the basin of the least squares, a golden
// section the minimum.

#include <pliant/models/fit_mesh.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/errors.h"
#include "base/text.h"
#include "fit/problem_impl.h"

namespace pliant {
namespace {

constexpr double kScanStep = 1.15;         ///< of the logarithm: half a decade
constexpr double kCreepTolerance = 1e-4;   ///< of the logarithm
constexpr double kCreepDifference = 1e-2;  ///< of the logarithm, for the derivative
constexpr double kCreepQuantile95 = 1.959964;
constexpr double kOnCreepBound = 1e-3;
constexpr double kMinDuration_s = 1e-9;  ///< squares of shorter steps would vanish

class Creeping {
  public:
    Creeping(const FitMeshProblem& fitted, std::span<const double> values, const FitCreep& creep)
        : m_impl(fitted.problem.impl()),
          m_network(m_impl.linear[m_impl.held_of[creep.load]]),
          m_values(values.begin(), values.end()),
          m_samples(creep.samples),
          m_force(m_impl.force_of(m_impl.cases[creep.load])) {
        std::stable_sort(m_samples.begin(), m_samples.end(),
                         [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
        m_step_s = m_samples.back().time_s / creep.steps;
    }

    std::span<const CreepSample> samples() const { return m_samples; }

    /// Displacements of the samples' nodes at their times; empty if the network has a free motion.
    std::vector<Vec3d> displacements(double damping) const {
        const double h = m_step_s;
        const auto first = m_network.factor(m_values, diagonal(1 / (h * h) + damping / h));
        const auto later =
            m_network.factor(m_values, diagonal(9 / (4 * h * h) + 3 * damping / (2 * h)));
        if (!first || !later) return {};
        const std::size_t count = m_force.size();
        std::vector<Vec3d> u(count), u_before(count), v(count), v_before(count), right(count);
        std::vector<Vec3d> found;
        const auto take = [&](std::int64_t step) {
            while (found.size() < m_samples.size()) {
                const CreepSample& sample = m_samples[found.size()];
                const double at = sample.time_s / h - double(step - 1);
                if (at > 1 + 1e-9) return;
                const auto n = std::size_t(sample.node);
                found.push_back((1 - at) * u_before[n] + at * u[n]);
            }
        };
        for (std::int64_t step = 1; found.size() < m_samples.size(); ++step) {
            const bool is_first = step == 1;
            for (std::size_t n = 0; n < count; ++n) {
                const double mass = m_impl.parts.nodes[n].mass;
                right[n] = m_force[n];
                if (is_first) continue;
                const Vec3d past = (1 / (2 * h)) * (4.0 * u[n] - u_before[n]);
                right[n] = right[n] + (mass * 3 / (2 * h)) * past +
                           (mass / (2 * h)) * (4.0 * v[n] - v_before[n]) + (mass * damping) * past;
            }
            std::vector<Vec3d> next = m_network.solve(is_first ? *first : *later, right);
            for (std::size_t n = 0; n < count; ++n) {
                const Vec3d speed =
                    is_first ? (1 / h) * next[n]
                             : (1 / (2 * h)) * (3.0 * next[n] - 4.0 * u[n] + u_before[n]);
                v_before[n] = v[n];
                v[n] = speed;
            }
            u_before.swap(u);
            u.swap(next);
            take(step);
        }
        return found;
    }

    /// Sum of the squared distances from the samples; infinite if the network has a free motion.
    double cost(double damping) {
        ++m_evaluations;
        const auto found = displacements(damping);
        if (found.empty()) return std::numeric_limits<double>::infinity();
        double sum = 0;
        for (std::size_t s = 0; s < found.size(); ++s) {
            const Vec3d off = found[s] - m_samples[s].displacement_mm;
            sum += dot(off, off);
        }
        return sum;
    }
    std::int64_t evaluations() const { return m_evaluations; }

  private:
    std::vector<double> diagonal(double factor) const {
        std::vector<double> diagonal;
        for (const SpringNode& node : m_impl.parts.nodes) diagonal.push_back(factor * node.mass);
        return diagonal;
    }

    const FitProblem::Impl& m_impl;
    const LinearNetwork& m_network;
    std::vector<double> m_values;
    std::vector<CreepSample> m_samples;  ///< by time
    std::vector<Vec3d> m_force;
    double m_step_s = 0;
    std::int64_t m_evaluations = 0;
};

Status check_creep(const FitProblem& problem, std::span<const double> values, const FitCreep& c) {
    if (const Status s = problem.impl().check_values(values); !s.ok()) return s;
    if (problem.impl().linear.empty())
        return expected_error("creep", "a problem of linear motion", "another");
    if (c.load >= problem.cases().size())
        return expected_error("creep.load",
                              "a load below " + std::to_string(problem.cases().size()),
                              std::to_string(c.load));
    if (c.samples.empty()) return expected_error("creep.samples", "one or more", "none");
    double last = 0;
    for (const CreepSample& s : c.samples) {
        if (s.node < 0 || std::size_t(s.node) >= problem.impl().parts.nodes.size())
            return expected_error(
                "creep.samples", "nodes below " + std::to_string(problem.impl().parts.nodes.size()),
                std::to_string(s.node));
        if (!(std::isfinite(s.time_s) && s.time_s >= 0) || !is_finite(s.displacement_mm))
            return expected_error("creep.samples", "finite numbers and times of 0 or more",
                                  text_of(s.time_s));
        last = std::max(last, s.time_s);
    }
    if (!(last >= kMinDuration_s))
        return expected_error("creep.samples", "a time of 1e-9 s or more", text_of(last));
    if (!(std::isfinite(c.high_per_s) && c.low_per_s > 0 && c.low_per_s < c.high_per_s))
        return expected_error("creep", "0 < low_per_s < high_per_s",
                              text_of(c.low_per_s) + " and " + text_of(c.high_per_s));
    if (c.steps < 2 || c.steps > 1'000'000)
        return expected_error("creep.steps", "2 to 1000000", std::to_string(c.steps));
    if (!(std::isfinite(c.noise_mm) && c.noise_mm >= 0))
        return expected_error("creep.noise_mm", "a number of 0 or more", text_of(c.noise_mm));
    return Ok{};
}

/// Minimum of a function between two logarithms, by golden section.
template <class Cost>
double golden_section(const Cost& cost, double low, double high) {
    const double ratio = (std::sqrt(5.0) - 1) / 2;
    double a = high - ratio * (high - low), b = low + ratio * (high - low);
    double at_a = cost(a), at_b = cost(b);
    while (high - low > kCreepTolerance) {
        if (at_a <= at_b) {
            high = b;
            b = a;
            at_b = at_a;
            a = high - ratio * (high - low);
            at_a = cost(a);
        } else {
            low = a;
            a = b;
            at_a = at_b;
            b = low + ratio * (high - low);
            at_b = cost(b);
        }
    }
    return (low + high) / 2;
}

FitInterval interval_of(const Creeping& creeping, double log_damping, double noise_mm) {
    const auto more = creeping.displacements(std::exp(log_damping + kCreepDifference));
    const auto less = creeping.displacements(std::exp(log_damping - kCreepDifference));
    double by2 = 0, moved2 = 0;
    for (std::size_t s = 0; s < more.size() && s < less.size(); ++s) {
        const Vec3d by = (1 / (2 * kCreepDifference)) * (more[s] - less[s]);
        by2 += dot(by, by);
        moved2 += dot(more[s], more[s]);
    }
    if (!(by2 > kMinInfluence * kMinInfluence * moved2))
        return {0, std::numeric_limits<double>::infinity(), false};
    const double reach = kCreepQuantile95 * noise_mm / std::sqrt(by2);
    return {std::exp(log_damping - reach), std::exp(log_damping + reach)};
}

}  // namespace

Result<CreepResult> fit_creep(const FitMeshProblem& fitted, std::span<const double> values,
                              const FitCreep& creep, const TaskArena& arena) {
    if (const Status s = check_creep(fitted.problem, values, creep); !s.ok()) return s.error();
    Creeping creeping(fitted, values, creep);
    const double low = std::log(creep.low_per_s), high = std::log(creep.high_per_s);
    const int points = std::max(3, int(std::ceil((high - low) / kScanStep)) + 1);
    const double apart = (high - low) / (points - 1);
    std::vector<double> costs(std::size_t(points), 0);
    std::vector<Creeping> each(std::size_t(points), creeping);
    arena.for_each(points, 1, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t p = begin; p < end; ++p)
            costs[std::size_t(p)] = each[std::size_t(p)].cost(std::exp(low + apart * double(p)));
    });
    const auto best = std::min_element(costs.begin(), costs.end());
    if (!std::isfinite(*best))
        return expected_error("creep", "a network that its load leaves in place", "one that isn't");
    const auto at = double(best - costs.begin());
    const double found = golden_section(
        [&](double log_damping) { return creeping.cost(std::exp(log_damping)); },
        std::max(low, low + apart * (at - 1)), std::min(high, low + apart * (at + 1)));
    CreepResult result{.damping_per_s = std::exp(found)};
    if (found <= low + kOnCreepBound) result.at_bound = FitBound::Low;
    if (found >= high - kOnCreepBound) result.at_bound = FitBound::High;
    result.rms_mm =
        std::sqrt(creeping.cost(result.damping_per_s) / (3.0 * double(creep.samples.size())));
    if (creep.noise_mm > 0) result.interval = interval_of(creeping, found, creep.noise_mm);
    result.evaluations = creeping.evaluations() + points;
    return result;
}

}  // namespace pliant
