// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The finite-element reference on a cube fixed at its bottom and pushed at its top: assembly of the
// matrix, its Cholesky factor, a solve with it, and matrix-free conjugate gradients on the lattice.
// One item is a node (per iteration). The floor of an iteration is the memory traffic of conjugate
// gradients without a preconditioner, at the speed of a plain loop over arrays of that size in the
// same run. The multigrid cycle is part of the time but not of the floor: it multiplies with the
// matrix four more times.

#include <pliant/models/fem.h>

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "interleaved.h"
#include "memory_floor.h"

namespace pliant::bench {
namespace {

HexLattice cube(int side) {
    return {{side, side, side}, {1, 1, 1}};
}

std::vector<Support> foot_of(const HexLattice& l) {
    std::vector<Support> supports;
    for (int j = 0; j < l.size.y; ++j)
        for (int i = 0; i < l.size.x; ++i) supports.push_back({.node = node_index(l, {i, j, 0})});
    return supports;
}

ElasticLoads push_on(const HexLattice& l) {
    return {.forces = {{node_index(l, {l.size.x / 2, l.size.y / 2, l.size.z - 1}), {1, 0, -1}}}};
}

const std::vector<ElasticMaterial> kElastin = {{6e5, 0.45, 1040}};

/// @param method  conjugate gradients: assembly only
void assemble(benchmark::State& state, ElasticMethod method) {
    const HexLattice lattice = cube(int(state.range(0)));
    const TaskArena arena(int(state.range(1)));
    const ElasticSolid solid{hex_mesh(lattice), kElastin};
    const auto supports = foot_of(lattice);
    std::vector<double> seconds, solve_seconds;
    double bytes = 0;
    for (auto _ : state) {
        Result<ElasticSolver> solver = Error{};
        seconds.push_back(seconds_of(
            [&] { solver = ElasticSolver::create(solid, supports, {.method = method}, arena); }));
        if (!solver) std::abort();
        state.SetIterationTime(seconds.back());
        bytes = double(solver->matrix_bytes());
        if (method == ElasticMethod::Cholesky)
            solve_seconds.push_back(
                seconds_of([&] { (void)solver->solve(push_on(lattice)).ok(); }));
    }
    const double nodes = double(node_count(lattice));
    state.counters["items"] = nodes;
    state.counters["ns/item"] = median(seconds) * 1e9 / nodes;
    state.counters["bytes/node"] = bytes / nodes;
    if (!solve_seconds.empty()) state.counters["solve_ms"] = median(solve_seconds) * 1e3;
}
/// Arguments: nodes along an edge, threads.
void fem_assembly(benchmark::State& state) {
    assemble(state, ElasticMethod::ConjugateGradients);
}
void fem_cholesky(benchmark::State& state) {
    assemble(state, ElasticMethod::Cholesky);
}

/// Arguments: nodes along an edge, materials mixed, threads. A whole solve to 10⁻⁶.
void fem_iteration(benchmark::State& state) {
    const HexLattice lattice = cube(int(state.range(0)));
    const TaskArena arena(int(state.range(2)));
    ElasticLattice solid{lattice, kElastin};
    if (state.range(1)) {
        solid.materials.push_back({1.2e6, 0.4, 1040});
        for (std::int64_t c = 0; c < cell_count(lattice); ++c)
            solid.material_of.push_back(std::int32_t(c * 7 % 5 % 2));
    }
    const auto solver = ElasticSolver::create(
        solid, foot_of(lattice), {.method = ElasticMethod::ConjugateGradients, .tolerance = 1e-6},
        arena);
    if (!solver) std::abort();
    const ElasticLoads loads = push_on(lattice);
    const auto first = solver->solve(loads);
    if (!first) std::abort();
    const int iterations = first->iterations;
    const double nodes = double(node_count(lattice));
    // Memory traffic of an iteration: search direction, its product, displacement, residual.
    const std::int64_t doubles = 8 * node_count(lattice);
    MemoryFloor floor(12 * doubles, 9 * doubles, arena);
    const int floor_turns = std::max(1, std::min(iterations, 30));
    const Turns turns = run_interleaved(
        state, "the floor, read and written by a plain loop", [] {},
        [&] { (void)solver->solve(loads).ok(); },
        [&] {
            for (int n = 0; n < floor_turns; ++n) floor.run();
        });
    turns.count(nodes * iterations, nodes * floor_turns);
    state.counters["iterations"] = iterations;
    state.counters["bytes/node"] = double(solver->matrix_bytes()) / nodes;
}

/// About 1 k to 1 M nodes; a factor of some 10⁴.
const bool registered = [] {
    using Sides = std::vector<std::pair<int, int>>;  // nodes along an edge, turns
    for (const auto& [side, turns] : Sides{{10, 9}, {22, 5}, {46, 1}})
        benchmark::RegisterBenchmark("fem_assembly", fem_assembly)
            ->ArgNames({"side", "threads"})
            ->ArgsProduct({{side}, {1, 2}})
            ->UseManualTime()
            ->Iterations(turns)
            ->Unit(benchmark::kMillisecond);
    for (const auto& [side, turns] : Sides{{10, 9}, {16, 3}, {22, 1}})
        benchmark::RegisterBenchmark("fem_cholesky", fem_cholesky)
            ->ArgNames({"side", "threads"})
            ->Args({side, 1})
            ->UseManualTime()
            ->Iterations(turns)
            ->Unit(benchmark::kMillisecond);
    for (const auto& [side, turns] : Sides{{10, 31}, {22, 9}, {46, 3}, {100, 1}})
        benchmark::RegisterBenchmark("fem_iteration", fem_iteration)
            ->ArgNames({"side", "mixed", "threads"})
            ->ArgsProduct({{side}, {0, 1}, {1, 2}})
            ->UseManualTime()
            ->Iterations(turns)
            ->Unit(benchmark::kMillisecond);
    return true;
}();

}  // namespace
}  // namespace pliant::bench
