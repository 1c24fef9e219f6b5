// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// From the lattice back to the grid: vectors of cells against their scalar twin, and against twelve
// tetrahedra. One item is a written voxel. Beside it the floor: the bytes that must be moved for a
// voxel (displacement and original value read, new value written) over the bandwidth that the same
// threads reach in the same run, copying.

#include <pliant/resample.h>

#include <cmath>
#include <cstring>
#include <optional>

#include "interleaved.h"

namespace pliant::bench {
namespace {

constexpr double kBytesPerVoxel = 3 * 4 + 2 + 2;

Volume wavy_volume(int side) {
    Volume volume;
    volume.grid.size = {side, side, side};
    std::vector<std::int16_t> voxels;
    voxels.reserve(voxel_count(volume.grid));
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
                voxels.push_back(std::int16_t(100 * std::sin(0.2 * x + 0.1 * y) + 50 * (z & 1)));
    volume.voxels = std::move(voxels);
    return volume;
}

/// Read and written by all threads of an arena [bytes/ns].
double copy_bandwidth(const TaskArena& arena) {
    constexpr std::int64_t kBytes = 64 << 20, kPiece = 1 << 20;
    static const std::vector<char> from(kBytes, 1);
    static std::vector<char> to(kBytes);
    const double seconds = seconds_of([&] {
        arena.for_each(kBytes, kPiece, [&](std::int64_t begin, std::int64_t end) {
            std::memcpy(to.data() + begin, from.data() + begin, std::size_t(end - begin));
        });
    });
    return 2 * kBytes / seconds * 1e-9;
}

std::optional<ChainMail> pushed_tissue(const Volume& volume, double length,
                                       const TaskArena& arena) {
    ChainMailSettings settings;
    settings.max_movement_mm = 500;
    auto tissue = ChainMail::create(volume, settings, arena);
    const double middle = volume.grid.size.x / 2 + 0.5, along = length / std::sqrt(3.0);
    if (!tissue.ok() || !tissue
                             ->push({.point_mm = {middle, middle, middle},
                                     .push_mm = {along, 0.8 * along, 1.1 * along}})
                             .ok())
        return std::nullopt;
    return std::move(tissue).value();
}

/// Arguments: side of the scan, length of the push in voxels, threads.
void resample(benchmark::State& state) {
    const TaskArena arena(int(state.range(2)));
    const Volume volume = wavy_volume(int(state.range(0)));
    const auto tissue = pushed_tissue(volume, double(state.range(1)), arena);
    if (!tissue) {
        state.SkipWithError("the push failed");
        return;
    }
    std::vector<double> cells_ms, scalar_ms, tetrahedra_ms, bandwidth;
    double items = 0;
    for (auto _ : state) {
        bandwidth.push_back(copy_bandwidth(arena));
        tetrahedra_ms.push_back(deform_volume(*tissue, Mapping::Tetrahedra).resample_ms);
        scalar_ms.push_back(deform_volume(*tissue, Mapping::CellsScalar).resample_ms);
        const Deformed subject = deform_volume(*tissue, Mapping::Cells);
        cells_ms.push_back(subject.resample_ms);
        items = double(subject.written_voxels);
        state.SetIterationTime(subject.resample_ms * 1e-3);
    }
    const double cells = median(cells_ms), tetrahedra = median(tetrahedra_ms);
    state.counters["items"] = items;
    state.counters["ns/item"] = cells / items * 1e6;
    state.counters["scalar_ns/item"] = median(scalar_ms) / items * 1e6;
    state.counters["reference_ns/item"] = tetrahedra / items * 1e6;
    state.counters["floor_ns/item"] = kBytesPerVoxel / median(bandwidth);
    state.counters["times_faster"] = tetrahedra / cells;
}

/// A drag with a million moved elements that swings from one side to the other, since on a way back
/// by less most elements stay where they are: each frame clamps them all and writes their voxels.
/// One item is a written voxel. Arguments: side of the scan, length of the drag in voxels, threads.
void whole_frame(benchmark::State& state) {
    const TaskArena arena(int(state.range(2)));
    const Volume volume = wavy_volume(int(state.range(0)));
    ChainMailSettings settings;
    settings.max_movement_mm = 500;
    auto tissue = ChainMail::create(volume, settings, arena);
    const double length = double(state.range(1)), along = length / std::sqrt(3.0);
    const double middle = volume.grid.size.x / 2 + 0.5;
    const Vec3d out{along, 0.8 * along, 1.1 * along};
    if (!tissue.ok() || !tissue->grab({.point_mm = {middle, middle, middle}}, 1.1 * length).ok()) {
        state.SkipWithError("the grab failed");
        return;
    }
    LiveDeformation live(*tissue);
    std::vector<double> drag_ms, resample_ms, frame_ms, items, moved, bandwidth;
    // Beforehand: between frames it would push everything out of the caches.
    for (int n = 0; n < 5; ++n) bandwidth.push_back(copy_bandwidth(arena));
    double side = 1;
    for (auto _ : state) {
        const auto report = tissue->drag_to(side * out);
        if (!report.ok()) {
            state.SkipWithError("the drag failed");
            return;
        }
        const LiveUpdate update = live.update();
        drag_ms.push_back(report->solve_ms);
        resample_ms.push_back(update.resample_ms);
        frame_ms.push_back(report->solve_ms + update.resample_ms);
        items.push_back(double(update.written_voxels));
        moved.push_back(double(report->moved_elements));
        state.SetIterationTime(frame_ms.back() * 1e-3);
        side = -side;
    }
    state.counters["items"] = median(items);
    state.counters["ns/item"] = median(frame_ms) / median(items) * 1e6;
    state.counters["floor_ns/item"] = kBytesPerVoxel / median(bandwidth);
    state.counters["moved"] = median(moved);
    state.counters["drag_ms"] = median(drag_ms);
    state.counters["resample_ms"] = median(resample_ms);
    state.counters["resample_ns/voxel"] = median(resample_ms) / median(items) * 1e6;
    state.counters["frame_ms"] = median(frame_ms);
}

BENCHMARK(resample)
    ->ArgNames({"side", "push", "threads"})
    ->ArgsProduct({{64}, {2}, {1, 2}})
    ->ArgsProduct({{96}, {5}, {1, 2}})
    ->ArgsProduct({{128}, {12}, {1, 2}})
    ->ArgsProduct({{192}, {26}, {1, 2}})
    ->ArgsProduct({{320}, {58}, {1, 2}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.1);
BENCHMARK(whole_frame)
    ->ArgNames({"side", "push", "threads"})
    ->ArgsProduct({{128}, {12}, {1, 2}})
    ->ArgsProduct({{192}, {26}, {1, 2}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.5);

}  // namespace
}  // namespace pliant::bench
