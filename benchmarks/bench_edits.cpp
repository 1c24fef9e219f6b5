// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cost of the history and of a cut. The push is the second one at its position, so that its
// elements have moved before: each brick is copied before the solve writes to it, and packed
// afterwards. One item is a moved element. The reference is the same push without a history.

#include <pliant/chainmail.h>

#include <cmath>
#include <optional>

#include "interleaved.h"

namespace pliant::bench {
namespace {

enum Kind { Homogeneous, Layers, Noise };

/// Soft tissue; layers of 60 HU each; or the noise of a CT on top of them.
Volume tissue_volume(int side, Kind kind) {
    Volume volume;
    volume.grid.size = {side, side, side};
    std::vector<std::int16_t> voxels(voxel_count(volume.grid), 40);
    std::uint32_t state = 1;
    if (kind != Homogeneous)
        for (int z = 0; z < side; ++z)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    state = state * 1664525u + 1013904223u;
                    const int noise = kind == Noise ? int(state >> 26) - 32 : 0;
                    voxels[voxel_index(volume.grid, {x, y, z})] =
                        std::int16_t(60 * ((x / 7 + y / 9 + z / 11) & 3) + noise);
                }
    volume.voxels = std::move(voxels);
    return volume;
}

/// Arguments: side of the lattice, length of the push [mm], kind.
void history_step(benchmark::State& state) {
    const int side = int(state.range(0));
    const TaskArena arena(1);
    const Volume volume = tissue_volume(side, Kind(state.range(2)));
    ChainMailSettings settings;
    settings.max_movement_mm = 400;
    settings.offset = 0.1;
    const double middle = side / 2 + 0.5, along = double(state.range(1)) / std::sqrt(3.0);
    const Push push{.point_mm = {middle, middle, middle}, .push_mm = {along, along, along}};
    std::vector<double> solve_s, undo_s, redo_s;
    Turns turns(state, "the same push without a history");
    std::int64_t moved = 0;
    std::size_t bytes = 0;
    ChainMail plain = [&] {
        ChainMailSettings without = settings;
        without.history_max_steps = 0;
        return std::move(ChainMail::create(volume, without, arena)).value();
    }();
    ChainMail kept = std::move(ChainMail::create(volume, settings, arena)).value();
    const Push back{.point_mm = push.point_mm + push.push_mm, .push_mm = -0.9 * push.push_mm};
    const Push forth{.point_mm = push.point_mm + 0.1 * push.push_mm, .push_mm = 0.9 * push.push_mm};
    benchmark::DoNotOptimize(plain.push(push));
    benchmark::DoNotOptimize(kept.push(push));
    bool is_forth = false;
    for (auto _ : state) {
        const Push& next = is_forth ? forth : back;
        is_forth = !is_forth;
        turns.add_reference(seconds_of([&] { benchmark::DoNotOptimize(plain.push(next)); }));
        const std::size_t before = kept.history_bytes();
        turns.add_subject(seconds_of([&] {
            const auto report = kept.push(next);
            moved = report->moved_elements;
            solve_s.push_back(report->solve_ms / 1e3);
        }));
        bytes = kept.history_bytes() - before;
        undo_s.push_back(seconds_of([&] { benchmark::DoNotOptimize(kept.undo()); }));
        redo_s.push_back(seconds_of([&] { benchmark::DoNotOptimize(kept.redo()); }));
    }
    turns.count(double(moved));
    const double per_element = 1e9 / double(moved);
    state.counters["solve_ns"] = median(solve_s) * per_element;
    state.counters["undo_ns"] = median(undo_s) * per_element;
    state.counters["redo_ns"] = median(redo_s) * per_element;
    state.counters["history_bytes/item"] = double(bytes) / double(moved);
}

BENCHMARK(history_step)
    ->Name("chainmail_history")
    ->ArgNames({"side", "mm", "kind"})
    ->Args({128, 14, Homogeneous})
    ->Args({128, 14, Layers})
    ->Args({128, 14, Noise})
    ->Args({288, 31, Homogeneous})
    ->Args({288, 31, Layers})
    ->Args({288, 31, Noise})
    ->UseManualTime()
    ->Iterations(8)
    ->Unit(benchmark::kMillisecond);

/// A plane through the middle of a lattice at rest. Argument: side. One item is a cut link.
void cut_plane(benchmark::State& state) {
    const int side = int(state.range(0));
    const TaskArena arena(1);
    const Volume volume = tissue_volume(side, Homogeneous);
    ChainMailSettings settings;
    settings.bounded = true;
    settings.history_max_steps = 0;
    const double far = 2.0 * side, middle = 0.5 * side;
    const CutSurface plane{
        {{middle - far, middle - 0.3 * far, -far}, {middle + far, middle + 0.3 * far, -far}},
        {0, 0.1 * far, 3 * far}};
    std::int64_t links = 0;
    for (auto _ : state) {
        ChainMail tissue = std::move(ChainMail::create(volume, settings, arena)).value();
        const auto report = tissue.cut(plane);
        links = report->cut_links;
        state.SetIterationTime(report->cut_ms / 1e3);
    }
    state.counters["links"] = double(links);
}

BENCHMARK(cut_plane)
    ->Name("chainmail_cut")
    ->ArgName("side")
    ->Arg(64)
    ->Arg(128)
    ->Arg(256)
    ->UseManualTime()
    ->Iterations(5)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
