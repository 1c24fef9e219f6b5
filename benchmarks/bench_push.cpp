// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A push from rest and the update of the deformed scan, as in a data set of deformed scans: every
// push begins at rest, in a phantom with air, soft tissue and bone. One item is a moved element.
// The reference sweeps without vector instructions and maps one voxel at a time.

#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <utility>
#include <vector>

#include "interleaved.h"

namespace pliant::bench {
namespace {

struct Times {
    std::vector<double> create, push, update;
};

/// Arguments: whether each push has a tissue and a copy of the scan of its own, threads.
void push_from_rest(benchmark::State& state) {
    const TaskArena arena(int(state.range(1)));
    const bool fresh = state.range(0) != 0;
    const Phantom phantom = make_phantom({.name = "airway"}, arena).value();
    const Volume& scan = phantom.volume;
    const PhantomLandmark& place = phantom.landmarks.front();
    const Push push{.point_mm = place.push_point_mm,
                    .push_mm = (6 / norm(place.push_mm)) * place.push_mm,
                    .sphere_radius_mm = 5};
    ChainMailSettings settings;
    settings.history_max_steps = 0;
    const auto tissue_of = [&](ChainMailSolver solver) {
        ChainMailSettings with = settings;
        with.solver = solver;
        return ChainMail::create(scan, with, arena).value();
    };
    ChainMail plain = tissue_of(ChainMailSolver::PlainSweep);
    ChainMail kept = tissue_of(ChainMailSolver::Sweep);
    LiveDeformation live = LiveDeformation::create(kept).value();
    Times times;
    double items = 0, written = 0;
    const auto turn = [&](ChainMail& tissue, LiveDeformation& deformed) {
        times.push.push_back(
            seconds_of([&] { items = double(tissue.push(push).value().moved_elements); }));
        times.update.push_back(
            seconds_of([&] { written = double(deformed.update().value().written_voxels); }));
    };
    Turns turns(state, "plain loops, one voxel at a time", arena.thread_count());
    for (auto _ : state) {
        if (turns.wants_reference()) {
            plain.reset();
            const double push_s = seconds_of([&] { (void)plain.push(push).ok(); });
            turns.add_reference(
                push_s + deform_volume(plain, Mapping::CellsScalar).value().resample_ms * 1e-3);
        }
        if (fresh) {
            std::vector<ChainMail> own;
            std::vector<LiveDeformation> own_live;
            times.create.push_back(seconds_of([&] {
                own.push_back(tissue_of(ChainMailSolver::Sweep));
                own_live.push_back(LiveDeformation::create(own.front()).value());
            }));
            turn(own.front(), own_live.front());
        } else {
            kept.reset();
            (void)live.update();
            turn(kept, live);
        }
        turns.add_subject(times.push.back() + times.update.back());
    }
    turns.count(items);
    state.counters["push_ns/item"] = median(times.push) / items * 1e9;
    state.counters["update_ns/item"] = median(times.update) / items * 1e9;
    state.counters["written"] = written;
    if (fresh) state.counters["create_ms"] = median(times.create) * 1e3;
}

BENCHMARK(push_from_rest)
    ->ArgNames({"fresh", "threads"})
    ->ArgsProduct({{0, 1}, {1, 2}})
    ->Iterations(101)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
