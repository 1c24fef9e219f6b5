// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A frame of a scan full of organs: five labels of the abdomen and their surroundings, an organ
// pushed to and fro by a hand. A frame is a push, a time step and the deformed scan; or, while a
// tool slides on the liver, a slide, a time step and the scan. Reference: the time step alone, of
// the same tissue while it moves by itself.

#include <pliant/models/organs.h>
#include <pliant/resample.h>

#include <chrono>
#include <cstdlib>
#include <string>
#include <vector>

#include "interleaved.h"

namespace pliant::bench {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// Arguments: whether the tool slides; threads.
void organs_frame(benchmark::State& state) {
    const bool slides = state.range(0) != 0;
    const TaskArena arena(int(state.range(1)));
    const char* folder = std::getenv("PLIANT_SHARED_DATA");
    const std::string scan = std::string(folder ? folder : "../shared/data") + "/abdomen_ct_3mm";
    const auto file =
        organ_file_of_labels(scan + ".nii.gz", scan + "-label.nii.gz", {1, 2, 3, 5, 6});
    if (!file.ok()) return state.SkipWithError(file.error().message.c_str());
    const auto made = make_organs(*file, arena);
    if (!made.ok()) return state.SkipWithError(made.error().message.c_str());
    const auto tissue = make_tissue(*made, made->scan, arena);
    if (!tissue.ok()) return state.SkipWithError(tissue.error().message.c_str());
    auto live = LiveDeformation::create(**tissue);
    if (!live.ok()) return state.SkipWithError(live.error().message.c_str());

    constexpr int kTurns = 6;  // then back
    // Pushes go into the liver; slides go along the surface in front of it.
    const Vec3d from = slides ? Vec3d{5, -294, 400} : Vec3d{5, -235, 400};
    const Vec3d way = slides ? Vec3d{2, 0, 0} : Vec3d{0, 2, 0};
    std::vector<double> hand_ms, step_ms, scan_ms;
    Turns turns(state, "a time step alone", int(state.range(1)));
    int turn = 0;
    std::int64_t contacts = 0;
    for (auto _ : state) {
        const int phase = turn++ % (2 * kTurns);
        const int at = phase < kTurns ? phase : 2 * kTurns - phase;
        const Push push{.point_mm = from + double(at) * way,
                        .push_mm = (phase < kTurns ? 1.0 : -1.0) * way,
                        .sphere_radius_mm = 12};
        const auto begin = Clock::now();
        bool went = true;
        if (slides) {
            const auto slid = (*tissue)->slide(1, push, {});
            went = slid.ok();
            if (went) contacts += slid->contacts;
        } else {
            went = (*tissue)->push(1, push).ok();
        }
        const double hand = ms_since(begin);
        const auto swept = (*tissue)->sweep();
        const auto update = live->update();
        if (!went || !swept.ok() || !update.ok()) return state.SkipWithError("the frame failed");
        hand_ms.push_back(hand);
        step_ms.push_back(swept->ms);
        scan_ms.push_back(update->resample_ms);
        turns.add_subject(ms_since(begin) / 1000);
        turns.add_reference(swept->ms / 1000);
    }
    turns.count(1);
    state.counters["hand_ms"] = median(hand_ms);
    state.counters["step_ms"] = median(step_ms);
    state.counters["scan_ms"] = median(scan_ms);
    if (slides) state.counters["contacts"] = double(contacts);
}
BENCHMARK(organs_frame)
    ->ArgNames({"slides", "threads"})
    ->Args({0, 2})
    ->Args({1, 2})
    ->Iterations(120)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
