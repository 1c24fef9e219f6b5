// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Sweeps of relaxation beside their memory floor. One item is an element, swept once. The floor
// reads and writes the displacements once and, for mixed materials, reads the links, at the speed
// of a plain loop over arrays of that size in the same run.

#include <pliant/chainmail.h>

#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include "interleaved.h"
#include "memory_floor.h"

namespace pliant::bench {
namespace {

/// One material, or the noise of a scan around it.
Volume noisy_volume(int side, bool mixed) {
    Volume volume;
    volume.grid.size = {side, side, side};
    std::vector<std::int16_t> values(voxel_count(volume.grid), 0);
    std::uint32_t state = 1;
    if (mixed)
        for (auto& value : values) {
            state = state * 1664525u + 1013904223u;
            value = std::int16_t(state >> 24);
        }
    volume.voxels = std::move(values);
    return volume;
}

/// Arguments: side of the pushed cube of elements, mixed materials, threads.
void chainmail_relax(benchmark::State& state) {
    const int side = int(state.range(0));
    const bool mixed = state.range(1) != 0;
    const TaskArena arena(int(state.range(2)));
    const Volume volume = noisy_volume(side + 4, mixed);
    ChainMailSettings settings;
    settings.offset = 0.32;
    std::vector<Vec3i> pushed;
    for (int z = 2; z < side + 2; ++z)
        for (int y = 2; y < side + 2; ++y)
            for (int x = 2; x < side + 2; ++x) pushed.push_back({x, y, z});
    const Vec3i middle{side / 2, side / 2, side / 2};
    const RelaxOptions options{.max_sweeps = 1, .held = {middle}};
    std::optional<ChainMail> tissue;
    const auto fresh = [&] {
        tissue.emplace(std::move(ChainMail::create(volume, settings, arena)).value());
        if (!tissue->push_elements(pushed, {0.25, -0.2, 0.15}).ok()) std::abort();
        // Pushes from the surface inwards, so that the whole lattice relaxes; also allocates the
        // workspace.
        for (int n = 0; n < 4; ++n)
            if (!tissue->relax(options).ok()) std::abort();
    };
    fresh();
    const auto workspace = tissue->relax(options)->workspace_bytes;
    const double items = double(pushed.size());
    MemoryFloor floor(std::int64_t(items) * 12, mixed ? workspace : 0, arena);
    constexpr double kManyItems = 2e6;
    const int sweeps = items > kManyItems ? 2 : 8;
    RelaxOptions several = options;
    several.max_sweeps = sweeps;
    const Turns turns = run_interleaved(
        state, "the floor, read and written by a plain loop", fresh,
        [&] { (void)tissue->relax(several).ok(); },
        [&] {
            for (int n = 0; n < sweeps; ++n) floor.run();
        },
        arena.thread_count());
    turns.count(sweeps * items);
    state.counters["workspace_bytes/element"] = double(workspace) / items;
}

/// About 1 k to 10 M elements.
const bool registered = [] {
    constexpr std::pair<int, int> kSidesAndTurns[] = {
        {10, 101}, {22, 31}, {46, 7}, {100, 3}, {216, 1}};
    for (const auto& [side, turns] : kSidesAndTurns)
        benchmark::RegisterBenchmark("chainmail_relax", chainmail_relax)
            ->ArgNames({"side", "mixed", "threads"})
            ->ArgsProduct({{side}, {0, 1}, {1, 2}})
            ->UseManualTime()
            ->Iterations(turns)
            ->Unit(benchmark::kMillisecond);
    return true;
}();

}  // namespace
}  // namespace pliant::bench
