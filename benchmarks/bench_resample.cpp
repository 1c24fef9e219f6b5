// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Whole cells against twelve tetrahedra. One item is a written voxel.

#include <pliant/resample.h>

#include <cmath>

#include "interleaved.h"

namespace pliant::bench {
namespace {

/// Arguments: length of the push in voxels, threads.
void resample(benchmark::State& state) {
    const TaskArena arena(int(state.range(1)));
    Volume volume;
    volume.grid.size = {128, 128, 128};
    std::vector<std::int16_t> voxels;
    for (int z = 0; z < 128; ++z)
        for (int y = 0; y < 128; ++y)
            for (int x = 0; x < 128; ++x)
                voxels.push_back(std::int16_t(100 * std::sin(0.2 * x + 0.1 * y) + 50 * (z & 1)));
    volume.voxels = std::move(voxels);
    ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
    const double along = double(state.range(0)) / std::sqrt(3.0);
    if (!tissue.push({.point_mm = {64.5, 64.5, 64.5}, .push_mm = {along, along, along}}).ok()) {
        state.SkipWithError("the push failed");
        return;
    }
    std::vector<double> cells_ms, tetrahedra_ms;
    double items = 0;
    for (auto _ : state) {
        const Deformed reference = deform_volume(tissue, Mapping::Tetrahedra);
        const Deformed subject = deform_volume(tissue, Mapping::Cells);
        tetrahedra_ms.push_back(reference.resample_ms);
        cells_ms.push_back(subject.resample_ms);
        items = double(subject.written_voxels);
        state.SetIterationTime(subject.resample_ms * 1e-3);
    }
    const double a = median(cells_ms), b = median(tetrahedra_ms);
    state.counters["items"] = items;
    state.counters["ns/item"] = a / items * 1e6;
    state.counters["reference_ns/item"] = b / items * 1e6;
    state.counters["times_faster"] = b / a;
}

BENCHMARK(resample)
    ->ArgNames({"push", "threads"})
    ->ArgsProduct({{4, 10}, {1, 2}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.5);

}  // namespace
}  // namespace pliant::bench
