// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter is pushed round a bend in a vessel of more than 20,000 tetrahedra, either all active
// or only the boxes near the catheter. A step is that of pliant vessel: five sub-steps of wall,
// contact and wire.

#include <pliant/models/catheter.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "interleaved.h"

namespace pliant::bench {
namespace {

/// Inner radius 4 mm, 210 mm long: straight, a third of a circle of radius 40, straight.
VesselWall long_bend() {
    const double turn = 2 * std::numbers::pi / 3, inner = 4;
    std::vector<CentrePoint> way;
    for (double z = 0; z < 60; z += 2) way.push_back({{0, 0, z}, inner});
    for (int n = 0; n <= 40; ++n) {
        const double angle = turn * n / 40;
        way.push_back({{40 * (1 - std::cos(angle)), 0, 60 + 40 * std::sin(angle)}, inner});
    }
    const Vec3d last = way.back().position_mm, ahead{std::sin(turn), 0, std::cos(turn)};
    for (double s = 2; s < 66; s += 2) way.push_back({last + s * ahead, inner});
    auto wall = swept_tube(way, {.thickness_mm = 1.2, .layers = 2, .sectors = 16});
    if (!wall) std::abort();
    return std::move(*wall);
}

/// One item is a tetrahedron of the vessel; the subject uses the boxes, the reference the whole
/// vessel. Arguments: inserted length [mm], threads.
void pbd_catheter(benchmark::State& state) {
    const TaskArena arena(int(state.range(1)));
    const VesselWall wall = long_bend();
    CatheterSettings settings{
        .catheter = {.length_mm = 250, .radius_mm = 0.8, .bend_n_mm2 = 100, .tip_bend_n_mm2 = 10},
        .entry = {{0, 0, 4}, {0, 0, 1}, 5}};
    auto local = CatheterScene::create(wall, settings);
    settings.local = false;
    auto all = CatheterScene::create(wall, settings);
    const int steps = int(state.range(0)) * 5;
    for (CatheterScene* scene : {&*local, &*all}) {
        (void)scene->command({.insert_mm_s = 200});
        if (!scene->step(steps, arena).ok()) state.SkipWithError("unstable");
        (void)scene->command({.insert_mm_s = 20});
    }
    const auto turns = run_interleaved(
        state, "all of it", [] {},
        [&] {
            if (!local->step(1, arena).ok()) state.SkipWithError("unstable");
        },
        [&] {
            if (!all->step(1, arena).ok()) state.SkipWithError("unstable");
        });
    const double cells = double(wall.mesh.cells.size());
    turns.count(cells);
    const CatheterMeasures m = all->measures();
    state.counters["tetrahedra"] = cells;
    state.counters["all_steps/s"] = 1e9 / (state.counters["reference_ns/item"].value * cells);
    state.counters["steps/s"] = 1e9 / (state.counters["ns/item"].value * cells);
    state.counters["active_%"] = 100 * local->quick_measures().active_tetrahedra / cells;
    state.counters["time_%"] = 100 / state.counters["times_faster"].value;
    state.counters["moved_mm"] = m.wall_moved_mm;
    state.counters["mean_%"] = 100 * m.volume.mean;
    state.counters["largest_%"] = 100 * m.volume.largest;
}
BENCHMARK(pbd_catheter)
    ->ArgNames({"in_mm", "threads"})
    ->ArgsProduct({{20, 80, 150}, {1, 2}})
    ->Iterations(41)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
