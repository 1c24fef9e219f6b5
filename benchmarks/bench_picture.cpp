// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Making phantoms, and looking at one of them.

#include <benchmark/benchmark.h>
#include <pliant/phantom.h>
#include <pliant/render.h>

namespace {

using namespace pliant;

void phantom(benchmark::State& state) {
    const TaskArena arena;
    for (auto _ : state) {
        auto made = make_phantom({.name = "airway"}, arena);
        if (!made.ok()) state.SkipWithError(made.error().message.c_str());
        benchmark::DoNotOptimize(made);
    }
}

void picture(benchmark::State& state, int threads, bool four_up) {
    const TaskArena arena(threads);
    const auto made = make_phantom({.name = "airway"}, arena);
    if (!made.ok() || made->landmarks.empty()) {
        state.SkipWithError("no airway to look at");
        return;
    }
    Endoscope endoscope;
    endoscope.eye_mm = made->landmarks.front().eye_mm;
    endoscope.look = made->landmarks.front().look;
    const RayCaster caster(made->volume, arena);
    for (auto _ : state) {
        const Image image = four_up
                                ? four_up_view(made->volume, {endoscope, {}, ""}, 1024, 1024, arena)
                                : caster.endoscope_view(endoscope, 512, 512);
        benchmark::DoNotOptimize(image.pixels.data());
    }
}

BENCHMARK(phantom)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(picture, endoscope_512_1_thread, 1, false)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(picture, endoscope_512_all_threads, 0, false)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(picture, four_up_1024_all_threads, 0, true)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
