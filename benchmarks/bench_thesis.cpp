// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Draeger2005, 6.1]: the push of 392 elements that took 170 ms, and 441 ms for the mapping to the
// grid. One item is a moved element; a turn is a push from rest and the update of the deformed
// scan. The reference uses the thesis's method, in order of the raise and with twelve tetrahedra
// per cell.

#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <utility>
#include <vector>

#include "interleaved.h"

namespace pliant::bench {
namespace {

constexpr std::int64_t kElements2005 = 392;
constexpr double kPush2005_ms = 170, kMapping2005_ms = 441;

/// As in research/results/chainmail/setups.cpp: at this slice distance the number of moved elements
/// equals the thesis's.
Volume thesis_volume() {
    Volume volume;
    volume.grid.size = {64, 64, 32};
    volume.grid.spacing_mm = {1, 1, 2.23};
    volume.voxels = std::vector<std::int16_t>(voxel_count(volume.grid), 40);
    return volume;
}

/// Arguments: threads.
void thesis_case(benchmark::State& state) {
    const TaskArena arena(int(state.range(0)));
    const Volume volume = thesis_volume();
    ChainMailSettings settings;
    settings.custom_law = [](int) {
        constexpr double kOffset = 0.15;
        const Vec3d even{kOffset, kOffset, kOffset};
        return ElementLimits{even, even, even, 500, false};
    };
    settings.history_max_steps = 0;
    ChainMail tissue = std::move(ChainMail::create(volume, settings, arena)).value();
    settings.solver = ChainMailSolver::Heap;
    ChainMail heap = std::move(ChainMail::create(volume, settings, arena)).value();
    const Push push{.point_mm = world_from_voxel(volume.grid, {31.5, 31.5, 15.5}),
                    .push_mm = {0, 1, 0}};
    LiveDeformation live = LiveDeformation::create(tissue).value();
    std::vector<double> pushes_s, updates_s;
    std::int64_t items = 0;
    Turns turns(state, "heap, twelve tetrahedra");
    for (auto _ : state) {
        heap.reset();
        const double heap_s = seconds_of([&] { (void)heap.push(push).ok(); });
        turns.add_reference(heap_s +
                            deform_volume(heap, Mapping::Tetrahedra).value().resample_ms * 1e-3);
        tissue.reset();
        (void)live.update();
        pushes_s.push_back(seconds_of([&] {
            const auto report = tissue.push(push);
            items = report.ok() ? report->moved_elements : 0;
        }));
        updates_s.push_back(seconds_of([&] { (void)live.update(); }));
        turns.add_subject(pushes_s.back() + updates_s.back());
    }
    if (items != kElements2005) state.SkipWithError("not the elements of the thesis");
    turns.count(double(items));
    state.counters["push_ms"] = median(pushes_s) * 1e3;
    state.counters["update_ms"] = median(updates_s) * 1e3;
    state.counters["ms_2005"] = kPush2005_ms + kMapping2005_ms;
}

BENCHMARK(thesis_case)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Iterations(301)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
