// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner step of identification: the distance of a spring lattice with other values from its
// reference. One item is an evaluation of the elastin cube of [Choi2004, 4.3] with three values and
// three loads; linear motion (a factor and a substitution for each load) against the equilibrium by
// Newton's method and conjugate gradients.

#include <pliant/models/fit.h>

#include <cstdlib>
#include <utility>
#include <vector>

#include "interleaved.h"

namespace pliant::bench {
namespace {

constexpr int kPoints = 4;  // simultaneous evaluations

FitBoxProblem cube(int side, FitMotion motion, const TaskArena& arena) {
    const double spacing = 100.0 / (side - 1);
    auto box = fit_box({.size = {side, side, side},
                        .spacing_mm = {spacing, spacing, spacing},
                        .loads = {{.name = "press", .force_n = {0, 0, -1}},
                                  {.name = "push x", .force_n = {1, 0, 0}, .across = 0.7},
                                  {.name = "push y", .force_n = {0, 1, 0}, .along = 0.7}},
                        .groups = FitBoxGroups::Kinds,
                        .volume_energy = true,
                        .shared_by_cells = true,
                        .settings = {.motion = motion}},
                       arena);
    if (!box.ok()) std::abort();
    return std::move(*box);
}

/// Arguments: nodes along an edge, threads.
void springs_fit(benchmark::State& state) {
    const TaskArena arena(int(state.range(1)));
    const int side = int(state.range(0));
    const FitBoxProblem linear = cube(side, FitMotion::Linear, arena);
    const FitBoxProblem newton = cube(side, FitMotion::Equilibrium, arena);
    double turn = 0;
    const auto evaluate = [&](const FitBoxProblem& box) {
        arena.for_each(kPoints, 1, [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t p = begin; p < end; ++p) {
                std::vector<double> values = box.closed_form;
                values[0] *= 1 + 0.01 * turn + 0.05 * double(p);
                if (!box.problem.evaluate(values).ok()) std::abort();
            }
        });
    };
    const auto turns = run_interleaved(
        state, "equilibrium by Newton's method", [&] { ++turn; }, [&] { evaluate(linear); },
        [&] { evaluate(newton); });
    turns.count(kPoints);
    state.counters["evaluations/s"] = 1e9 / state.counters["ns/item"].value;
}
BENCHMARK(springs_fit)
    ->ArgNames({"side", "threads"})
    ->Args({6, 1})
    ->Args({10, 1})
    ->Args({10, 2})
    ->Iterations(11)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
