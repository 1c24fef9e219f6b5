// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Frames of a drag in the elastic scan: a ball at the wall of a phantom airway goes 0.5 mm a frame,
// to and fro. A frame is the push, two iterations for each stride, and the displacement of what
// lags most. One item is a node of all lattices. The reference is a finite-element solution of a
// lattice of the window's size to a tenth of the load, from rest, with its set-up left out.

#include <pliant/models/fem.h>
#include <pliant/tissues.h>

#include <cstdlib>
#include <utility>
#include <variant>
#include <vector>

#include "interleaved.h"

namespace pliant::bench {
namespace {

constexpr std::int64_t kShownElements = 200'000;

ElasticSolver cube_solver(int side, const TaskArena& arena) {
    const HexLattice lattice{{side, side, side}, {1, 1, 1}};
    std::vector<Support> supports;
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) supports.push_back({.node = node_index(lattice, {i, j, 0})});
    auto solver = ElasticSolver::create(
        ElasticLattice{lattice, {{1e4, 0.45, 1000}}}, std::move(supports),
        {.method = ElasticMethod::ConjugateGradients, .tolerance = 0.1}, arena);
    if (!solver) std::abort();
    return std::move(*solver);
}

/// Arguments: cells along a window's edge, threads.
void elastic_drag(benchmark::State& state) {
    const int window = int(state.range(0));
    const TaskArena arena(int(state.range(1)));
    const Phantom phantom =
        make_phantom({.name = "airway", .size = {192, 192, 192}}, arena).value();
    ElasticScanSettings settings;
    settings.window_cells = window;
    auto made = make_elastic(phantom.volume, settings, arena);
    if (!made) std::abort();
    Tissue& tissue = **made;
    const PhantomLandmark& place = phantom.landmarks.front();
    const Vec3d step = (0.5 / norm(place.push_mm)) * place.push_mm;
    const ElasticSolver solver = cube_solver(window + 1, arena);
    const HexLattice lattice{{window + 1, window + 1, window + 1}, {1, 1, 1}};
    const ElasticLoads loads{
        .forces = {{node_index(lattice, {window / 2, window / 2, window}), {1, 0, -1}}}};
    std::vector<double> push_s, show_s;
    Turns turns(state, "elements of one window from rest", arena.thread_count());
    int frame = 0;
    for (auto _ : state) {
        if (turns.wants_reference())
            turns.add_reference(seconds_of([&] { (void)solver.solve(loads).ok(); }));
        const int at = frame % 16, sign = at < 8 ? 1 : -1;
        const Vec3d centre = place.push_point_mm + double(at < 8 ? at : 16 - at) * step;
        push_s.push_back(seconds_of([&] {
            if (!tissue.push(
                    1, {.point_mm = centre, .push_mm = double(sign) * step, .sphere_radius_mm = 5}))
                std::abort();
        }));
        show_s.push_back(
            seconds_of([&] { (void)tissue.approach_deformation(kShownElements).ok(); }));
        turns.add_subject(push_s.back() + show_s.back());
        ++frame;
    }
    double nodes = 0;
    for (const NamedValue& figure : tissue.figures())
        if (figure.name == "nodes") nodes = double(std::get<std::int64_t>(figure.value));
    turns.count(nodes);
    state.counters["push_ms"] = median(push_s) * 1e3;
    state.counters["show_ms"] = median(show_s) * 1e3;
}

BENCHMARK(elastic_drag)
    ->ArgNames({"window", "threads"})
    ->Args({30, 1})
    ->Args({30, 2})
    ->Args({46, 2})
    ->Iterations(64)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
