// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pictures. One item is a ray.

#include <benchmark/benchmark.h>
#include <pliant/render.h>
#include <pliant/volume.h>

namespace pliant::bench {
namespace {

void draw_endoscope(benchmark::State& state, Style style) {
    const TaskArena arena(int(state.range(0)));
    const auto phantom = make_phantom({.name = "airway", .size = {160, 160, 160}}, arena);
    if (!phantom) {
        state.SkipWithError("no phantom");
        return;
    }
    const RayCaster caster(phantom->volume, arena);
    Endoscope endoscope;
    endoscope.eye_mm = phantom->landmarks.at(0).eye_mm;
    endoscope.look = phantom->landmarks.at(0).look;
    endoscope.style = style;
    for (auto _ : state) benchmark::DoNotOptimize(caster.endoscope_view(endoscope, 512, 512));
    state.counters["rays/s"] =
        benchmark::Counter(512 * 512, benchmark::Counter::kIsIterationInvariantRate);
}

/// Arguments: threads.
void endoscope_view(benchmark::State& state) {
    draw_endoscope(state, Style::Plain);
}
void endoscope_real(benchmark::State& state) {
    draw_endoscope(state, Style::Real);
}

void ray_caster_bricks(benchmark::State& state) {
    const TaskArena arena(int(state.range(0)));
    const auto phantom = make_phantom({.name = "airway", .size = {160, 160, 160}}, arena);
    if (!phantom) {
        state.SkipWithError("no phantom");
        return;
    }
    for (auto _ : state) benchmark::DoNotOptimize(RayCaster(phantom->volume, arena));
}

BENCHMARK(endoscope_view)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(endoscope_real)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(ray_caster_bricks)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
