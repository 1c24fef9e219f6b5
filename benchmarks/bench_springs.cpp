// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Force transmittal against a naive port of [Choi2004] (naive_springs.h). One item is a node of a
// step. The cases of Table 3 are a sheet of 50 × 50 nodes pressed in its middle; search and update
// are separate, as in the table. The liver is read from $PLIANT_SHARED_DATA or ../shared/data.

#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/springs.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "interleaved.h"
#include "naive_springs.h"

namespace pliant::bench {
namespace {

constexpr int kStepsPerTurn = 20;
constexpr int kMiddle = 25 + 50 * 25;
const Vec3d kForce{0.02, 0.01, 0};

SpringNetwork paper_sheet() {
    return *SpringNetwork::create(
        *springs_of_sheet({.columns = 50, .rows = 50, .node_damping = 10}));
}

SpringTissue pressed(const SpringNetwork& network, const SpringSettings& settings, int node) {
    SpringTissue tissue = std::move(SpringTissue::create(network, settings)).value();
    const int nodes[] = {node};
    const Vec3d forces[] = {kForce};
    if (!tissue.load(nodes, forces).ok()) std::abort();
    return tissue;
}

void compare_steps(benchmark::State& state, const SpringNetwork& network,
                   const SpringSettings& settings, int node, const TaskArena& arena) {
    SpringTissue tissue = pressed(network, settings, node);
    NaivePort naive(network, tissue.time_step());
    naive.load(node, kForce);
    naive.search(node, settings.depth);
    const auto first = tissue.step(1, arena);
    naive.step();
    const double nodes = first.ok() ? first->active_nodes : 0;
    const auto turns = run_interleaved(
        state, "naive port", [] {},
        [&] {
            if (!tissue.step(kStepsPerTurn, arena).ok()) state.SkipWithError("unstable");
        },
        [&] {
            for (int n = 0; n < kStepsPerTurn; ++n) naive.step();
        });
    turns.count(nodes * kStepsPerTurn);
    state.counters["nodes"] = nodes;
    state.counters["us/step"] = state.counters["ns/item"].value * nodes * 1e-3;
    state.counters["reference_us/step"] = state.counters["reference_ns/item"].value * nodes * 1e-3;
}

/// Argument: layers.
void springs_update(benchmark::State& state) {
    const TaskArena arena(1);
    compare_steps(state, paper_sheet(), {.depth = int(state.range(0))}, kMiddle, arena);
}
BENCHMARK(springs_update)
    ->ArgName("layers")
    ->ArgsProduct({{1, 2, 3, 4, 5, 10, 15, 20}})
    ->Iterations(501)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

/// The breadth-first search alone.
void springs_search(benchmark::State& state) {
    const SpringNetwork network = paper_sheet();
    NaivePort naive(network, 0.1);
    const int sources[] = {kMiddle};
    std::size_t nodes = 0;
    const auto turns = run_interleaved(
        state, "naive port", [] {},
        [&] {
            const auto order = transmittal_order(network, sources, int(state.range(0)));
            nodes = order.ok() ? order->nodes.size() : 0;
        },
        [&] { naive.search(kMiddle, int(state.range(0))); });
    turns.count(double(nodes));
    state.counters["us"] = state.counters["ns/item"].value * double(nodes) * 1e-3;
}
BENCHMARK(springs_search)
    ->ArgName("layers")
    ->Arg(1)
    ->Arg(5)
    ->Arg(10)
    ->Arg(20)
    ->Iterations(501)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

/// A new contact: search, numbering and one step.
void springs_new_contact(benchmark::State& state) {
    const TaskArena arena(1);
    const SpringNetwork network = paper_sheet();
    const int depth = int(state.range(0));
    SpringTissue tissue = pressed(network, {.depth = depth}, kMiddle);
    NaivePort naive(network, tissue.time_step());
    int turn = 0, nodes = 0;
    const auto node = [&] { return kMiddle + turn % 7 - 3 + 50 * (turn / 7 % 7 - 3); };
    const auto turns = run_interleaved(
        state, "naive port", [&] { ++turn; },
        [&] {
            const int at[] = {node()};
            const Vec3d forces[] = {kForce};
            (void)tissue.load(at, forces).ok();
            const auto report = tissue.step(1, arena);
            nodes = report.ok() ? report->active_nodes : 0;
        },
        [&] {
            naive.search(node(), depth);
            naive.step();
        });
    turns.count(double(nodes));
    state.counters["us"] = state.counters["ns/item"].value * nodes * 1e-3;
}
BENCHMARK(springs_new_contact)
    ->ArgName("layers")
    ->Arg(5)
    ->Arg(10)
    ->Arg(20)
    ->Iterations(501)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

SpringNetwork cube(int side) {
    return *SpringNetwork::create(
        *springs_of_lattice({.size = {side, side, side}, .node_damping = 20}));
}

/// A whole cube with edges and face diagonals. Arguments: nodes along an edge, threads.
void springs_lattice(benchmark::State& state) {
    const TaskArena arena(int(state.range(1)));
    const int side = int(state.range(0));
    compare_steps(state, cube(side), {.depth = 3 * side}, side * side * side / 2, arena);
}
BENCHMARK(springs_lattice)
    ->ArgNames({"side", "threads"})
    ->Args({10, 1})
    ->Args({22, 1})
    ->Args({46, 1})
    ->Args({46, 2})
    ->Args({100, 1})
    ->Args({100, 2})
    ->Iterations(11)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// A liver of 54 789 tetrahedra, E = 15 kPa, held at one end and pressed at its top with 10 layers.
/// Arguments: ν in percent, 25: no volume energy; the time step that masses are raised for [µs], 0:
/// they aren't. The reference is the scalar code. Counters: steps of simulated time, as a multiple
/// of real time, and the added mass.
void springs_liver(benchmark::State& state) {
    const TaskArena arena(1);
    const char* folder = std::getenv("PLIANT_SHARED_DATA");
    const auto mesh = read_tetrahedra(std::string(folder ? folder : "../shared/data") +
                                      "/liver_set/liver_tet.vtu");
    if (!mesh.ok()) return state.SkipWithError(mesh.error().message.c_str());
    const double young = 15000, ratio = 0.01 * double(state.range(0));
    const double shear = young / (2 * (1 + ratio)),
                 lambda = young * ratio / ((1 + ratio) * (1 - 2 * ratio));
    auto parts = *springs_of_elastic_tetrahedra(
        mesh->nodes_mm, mesh->cells,
        {.stiffness = shear, .density = 1e-3, .bulk = ratio > 0.25 ? lambda - shear : 0});
    const auto by = [](int axis) {
        return [axis](const SpringNode& a, const SpringNode& b) {
            return a.rest[axis] < b.rest[axis];
        };
    };
    const auto& nodes = parts.nodes;
    const double end = std::min_element(nodes.begin(), nodes.end(), by(0))->rest.x + 15;
    const auto top = int(std::max_element(nodes.begin(), nodes.end(), by(2)) - nodes.begin());
    for (SpringNode& node : parts.nodes) {
        node.fixed = node.rest.x < end;
        node.damping = 400 * node.mass;
    }
    double added = 0;
    if (state.range(1) > 0) added = raise_masses(parts, 1e-6 * double(state.range(1)))->share;
    const auto network = SpringNetwork::create(std::move(parts));
    const auto pressed = [&](bool vectors) {
        SpringTissue tissue =
            std::move(SpringTissue::create(*network, {.vectors = vectors})).value();
        const int at[] = {top};
        const Vec3d forces[] = {{0, 0, -2000}};
        if (!tissue.load(at, forces).ok()) std::abort();
        return tissue;
    };
    SpringTissue tissue = pressed(true), scalar = pressed(false);
    const auto first = tissue.step(1, arena);
    const double moving = first.ok() ? first->active_nodes : 0;
    const auto run = [&](SpringTissue& one) {
        if (!one.step(kStepsPerTurn, arena).ok()) state.SkipWithError("unstable");
    };
    const auto turns = run_interleaved(
        state, "scalar code", [] {}, [&] { run(tissue); }, [&] { run(scalar); });
    turns.count(moving * kStepsPerTurn);
    const double us = state.counters["ns/item"].value * moving * 1e-3;
    state.counters["nodes"] = moving;
    state.counters["us/step"] = us;
    state.counters["real_time"] = 1e6 * tissue.time_step() / us;
    state.counters["added_mass_percent"] = 100 * added;
}
BENCHMARK(springs_liver)
    ->ArgNames({"nu", "raised_us"})
    ->ArgsProduct({{25, 45}, {0, 100, 150, 200}})
    ->Iterations(31)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// A network in a step of implicit Euler of 1/60 s.
class MovedOrgan {
  public:
    MovedOrgan(const SpringNetwork& network, bool assembled)
        : m_tissue(SpringTissue::create(network, {.solver = SpringSolver::ImplicitEuler,
                                                  .time_step = 1.0 / 60,
                                                  .solve_tolerance = 1e-3,
                                                  .assembled = assembled})
                       .value()) {
        const auto nodes = network.nodes();
        const Vec3d top = std::max_element(nodes.begin(), nodes.end(),
                                           [](const SpringNode& a, const SpringNode& b) {
                                               return a.rest.z < b.rest.z;
                                           })
                              ->rest;
        for (std::int32_t n = 0; n < network.node_count(); ++n) {
            const SpringNode& node = nodes[std::size_t(n)];
            if (!node.fixed && norm(node.rest - top) < 20) m_held.push_back(n);
        }
    }
    double time_step() const { return m_tissue.time_step(); }
    /// Four strides of a tool at its top, six steps that it stays, and six after it has let go.
    void push_and_release(const TaskArena& arena) {
        bool ok = m_tissue.hold(m_held).ok();
        for (int turn = 0; turn < kSteps; ++turn) {
            if (turn < 4) ok = ok && m_tissue.shift_held({0.5, 0, -4}).ok();
            if (turn == 10) ok = ok && m_tissue.hold({}).ok();
            const auto report = m_tissue.step(1, arena);
            if (!ok || !report.ok()) std::abort();
            iterations += report->iterations;
            ++steps;
        }
    }

    static constexpr int kSteps = 16;
    std::int64_t steps = 0, iterations = 0;

  private:
    SpringTissue m_tissue;
    std::vector<std::int32_t> m_held;
};

/// A whole liver filled with about N tetrahedra, or that of springs_liver (0), E = 15 kPa,
/// held at one end, as `pliant serve ORGAN --network` moves it. Arguments: N, ν in
/// percent. The reference is the solver link by link. Counters: steps of simulated time, as a
/// multiple of real time, and iterations of conjugate gradients in a step.
void springs_organ(benchmark::State& state) {
    const TaskArena arena(1);
    const char* folder = std::getenv("PLIANT_SHARED_DATA");
    const std::string livers = std::string(folder ? folder : "../shared/data") + "/liver_set/";
    const auto mesh = [&]() -> Result<TetMesh> {
        if (state.range(0) == 0) return read_tetrahedra(livers + "liver_tet.vtu");
        auto surface = read_surface(livers + "liver.vtk");
        if (!surface.ok()) return surface.error();
        auto filled = fill_surface(std::move(*surface), {.tetrahedra = state.range(0)}, arena);
        if (!filled.ok()) return filled.error();
        return std::move(filled->mesh);
    }();
    if (!mesh.ok()) return state.SkipWithError(mesh.error().message.c_str());
    const double young = 15000, ratio = 0.01 * double(state.range(1));
    const double shear = young / (2 * (1 + ratio)),
                 lambda = young * ratio / ((1 + ratio) * (1 - 2 * ratio));
    auto parts = *springs_of_elastic_tetrahedra(
        mesh->nodes_mm, mesh->cells,
        {.stiffness = shear, .density = 1e-3, .bulk = ratio > 0.25 ? lambda - shear : 0});
    double end = parts.nodes[0].rest.x;
    for (const SpringNode& node : parts.nodes) end = std::min(end, node.rest.x);
    for (SpringNode& node : parts.nodes) {
        node.fixed = node.rest.x < end + 25;
        node.damping = 20 * node.mass;
    }
    const auto network = SpringNetwork::create(std::move(parts));
    MovedOrgan organ(*network, true), reference(*network, false);
    for (MovedOrgan* one : {&organ, &reference}) {  // the coarse space is made once
        one->push_and_release(arena);
        one->steps = one->iterations = 0;
    }
    const auto turns = run_interleaved(
        state, "link by link", [] {}, [&] { organ.push_and_release(arena); },
        [&] { reference.push_and_release(arena); });
    turns.count(MovedOrgan::kSteps);
    state.counters["tetrahedra"] = double(network->cells().size());
    state.counters["real_time"] = 1e9 * organ.time_step() / state.counters["ns/item"].value;
    state.counters["iterations"] = double(organ.iterations) / double(organ.steps);
    state.counters["reference_iterations"] = double(reference.iterations) / double(reference.steps);
}
BENCHMARK(springs_organ)
    ->ArgNames({"tetrahedra", "nu"})
    ->ArgsProduct({{0, 6000, 20000}, {25, 45}})
    ->Iterations(11)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// The deepest region under the surface of a cube of 80³ nodes with a step of at most a
/// millisecond: its layers and nodes are counters.
void springs_1khz(benchmark::State& state) {
    const TaskArena arena(int(state.range(0)));
    const int side = 80;
    const SpringNetwork network = cube(side);
    int best = 0, best_nodes = 0;
    for (auto _ : state) {
        SpringTissue tissue = pressed(network, {}, side / 2 + side * (side / 2));
        double last = 0;
        for (int depth = 1; depth < side; ++depth) {
            (void)tissue.set_depth(depth).ok();
            std::vector<double> seconds;
            int nodes = 0;
            for (int n = 0; n < 15; ++n)
                seconds.push_back(seconds_of([&] {
                    const auto report = tissue.step(1, arena);
                    nodes = report.ok() ? report->active_nodes : 0;
                }));
            last = median(seconds);
            if (last > 1e-3) break;
            best = depth;
            best_nodes = nodes;
        }
        state.SetIterationTime(last);
    }
    state.counters["layers"] = best;
    state.counters["items"] = best_nodes;
}
BENCHMARK(springs_1khz)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
