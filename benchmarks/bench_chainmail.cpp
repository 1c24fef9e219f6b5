// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The sweep against the heap, on the same push from the same state. One item is a moved element.
// Timed is all of a moving contact: bricks made, the solve, the step's limits, the move.

#include <pliant/chainmail.h>

#include <cmath>
#include <cstdlib>
#include <optional>

#include "interleaved.h"

namespace pliant::bench {
namespace {

/// Four materials in wavy layers, limits from 0.02 to 0.4 of a link, or one of 0.2.
Volume layered_volume(int side, bool heterogeneous) {
    Volume volume;
    volume.grid.size = {side, side, side};
    std::vector<std::int16_t> labels(voxel_count(volume.grid), 0);
    if (heterogeneous)
        for (int z = 0; z < side; ++z)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x)
                    labels[voxel_index(volume.grid, {x, y, z})] =
                        std::int16_t((int(x + 5 * std::sin(0.2 * y)) / 7 +
                                      int(y + 4 * std::sin(0.3 * z)) / 9 + z / 11) &
                                     3);
    volume.voxels = std::move(labels);
    return volume;
}

MaterialLaw law_of(bool heterogeneous) {
    return [heterogeneous](int value) {
        constexpr double kLimits[] = {0.02, 0.05, 0.15, 0.4};
        const double limit = heterogeneous && value >= 0 ? kLimits[value & 3] : 0.2;
        return ElementLimits{
            {limit, limit, limit}, {limit, limit, limit}, {limit, limit, limit}, 1000, false};
    };
}

/// Arguments: side of the lattice, length of the push in voxels, heterogeneous, threads.
void moving_contact(benchmark::State& state) {
    const int side = int(state.range(0));
    const double length = double(state.range(1));
    const bool heterogeneous = state.range(2) != 0;
    const TaskArena arena(int(state.range(3)));
    const Volume volume = layered_volume(side, heterogeneous);
    ChainMailSettings settings;
    settings.custom_law = law_of(heterogeneous);
    std::optional<ChainMail> sweep, heap;
    const auto fresh = [&] {
        settings.solver = ChainMailSolver::Sweep;
        sweep.emplace(std::move(ChainMail::create(volume, settings, arena)).value());
        settings.solver = ChainMailSolver::Heap;
        heap.emplace(std::move(ChainMail::create(volume, settings, arena)).value());
    };
    const double middle = side / 2 + 0.5, along = length / std::sqrt(3.0);
    const Push push{.point_mm = {middle, middle, middle}, .push_mm = {along, along, along}};
    const auto moved = [&](ChainMail& tissue) {
        const auto report = tissue.push(push);
        if (!report.ok()) std::abort();
        return report->moved_elements;
    };
    fresh();
    const std::int64_t items = moved(*sweep);
    if (items != moved(*heap) || sweep->hash() != heap->hash()) {
        state.SkipWithError("the solvers disagree");
        return;
    }
    run_interleaved(
        state, double(items), fresh, [&] { moved(*sweep); }, [&] { moved(*heap); });
}

BENCHMARK(moving_contact)
    ->ArgNames({"side", "push", "heterogeneous", "threads"})
    ->ArgsProduct({{50}, {5}, {0}, {1, 2}})
    ->ArgsProduct({{160}, {8, 24}, {0}, {1, 2}})
    ->ArgsProduct({{160}, {2, 5}, {1}, {1, 2}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.5);

}  // namespace
}  // namespace pliant::bench
