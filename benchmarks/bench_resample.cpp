// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Resampling of the lattice to the grid: vectorised cells against twelve tetrahedra, and against
// the scalar version; and whole frames. One item is a written voxel. The floor is the necessary
// memory traffic per voxel (displacement and original value read, new value written) over the
// bandwidth of a copy by the same threads in the same run.

#include <pliant/chainmail.h>
#include <pliant/resample.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "interleaved.h"

namespace pliant::bench {
namespace {

constexpr double kBytesPerVoxel = 3 * 4 + 2 + 2;

/// One value, or values whose limits differ by some percent.
Volume wavy_volume(int side, bool heterogeneous) {
    Volume volume;
    volume.grid.size = {side, side, side};
    std::vector<std::int16_t> voxels(voxel_count(volume.grid), 40);
    if (heterogeneous)
        for (int z = 0; z < side; ++z)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x)
                    voxels[voxel_index(volume.grid, {x, y, z})] =
                        std::int16_t(100 * std::sin(0.2 * x + 0.1 * y) + 50 * (z & 1));
    volume.voxels = std::move(voxels);
    return volume;
}

/// About 1 k to 10 M written voxels.
struct Size {
    int side;  ///< of the scan
    int push;  ///< length in voxels
    int turns;
};
constexpr Size kSizes[] = {{64, 2, 101}, {96, 5, 51}, {128, 12, 21}, {192, 26, 21}, {320, 58, 5}};

/// Bandwidth of reads and writes by all threads of an arena [bytes/ns].
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

/// Median of five copies. Call it before the measurement, because the copies evict everything from
/// the caches.
double median_bandwidth(const TaskArena& arena) {
    std::vector<double> copies;
    for (int n = 0; n < 5; ++n) copies.push_back(copy_bandwidth(arena));
    return median(copies);
}

/// Number of page faults of this process so far.
std::int64_t pages_made() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_minflt;
}

/// Time to write to so many pages of a fresh copy by all threads: the system's cost of the pages.
double seconds_of_pages(const Volume& volume, std::int64_t pages, const TaskArena& arena) {
    constexpr std::int64_t kPage = 4096 / sizeof(std::int16_t), kPiece = 64;
    Volume copy = volume;
    auto& voxels = std::get<VoxelArray<std::int16_t>>(copy.voxels);
    const std::int64_t count = std::min(pages, std::int64_t(voxels.size()) / kPage);
    return seconds_of([&] {
        arena.for_each(count, kPiece, [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t n = begin; n < end; ++n) ++voxels[std::size_t(n * kPage)];
        });
    });
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

/// Arguments: side of the scan, length of the push in voxels, heterogeneous, threads.
void resample(benchmark::State& state) {
    const TaskArena arena(int(state.range(3)));
    const Volume volume = wavy_volume(int(state.range(0)), state.range(2) != 0);
    const auto tissue = pushed_tissue(volume, double(state.range(1)), arena);
    if (!tissue) {
        state.SkipWithError("the push failed");
        return;
    }
    const double bandwidth = median_bandwidth(arena);
    Turns turns(state, "twelve tetrahedra", arena.thread_count());
    std::vector<double> scalar_ms, pages_s;
    double items = 0;
    for (auto _ : state) {
        if (turns.wants_reference()) {
            turns.add_reference(deform_volume(*tissue, Mapping::Tetrahedra).value().resample_ms *
                                1e-3);
            scalar_ms.push_back(deform_volume(*tissue, Mapping::CellsScalar).value().resample_ms);
        }
        const std::int64_t pages_before = pages_made();
        const Deformed subject = deform_volume(*tissue, Mapping::Cells).value();
        pages_s.push_back(seconds_of_pages(volume, pages_made() - pages_before, arena));
        items = double(subject.written_voxels);
        turns.add_subject(subject.resample_ms * 1e-3);
    }
    turns.count(items);
    state.counters["pages_ns/item"] = median(pages_s) / items * 1e9;
    state.counters["scalar_ns/item"] = median(scalar_ms) / items * 1e6;
    state.counters["floor_ns/item"] = kBytesPerVoxel / bandwidth;
}

/// A drag that swings from one side to the other: on a shorter way back most elements would not
/// move. Each frame clamps all elements and writes their voxels. The reference pushes the same
/// elements and maps them in plain loops. Arguments as above.
void whole_frame(benchmark::State& state) {
    const TaskArena arena(int(state.range(3)));
    const Volume volume = wavy_volume(int(state.range(0)), state.range(2) != 0);
    ChainMailSettings settings;
    settings.max_movement_mm = 500;
    auto tissue = ChainMail::create(volume, settings, arena);
    settings.solver = ChainMailSolver::PlainSweep;
    auto plain = ChainMail::create(volume, settings, arena);
    const double length = double(state.range(1)), along = length / std::sqrt(3.0);
    const double middle = volume.grid.size.x / 2 + 0.5;
    const Vec3d out{along, 0.8 * along, 1.1 * along};
    const Push place{.point_mm = {middle, middle, middle}};
    const auto held = plain.ok() ? plain->elements_at(place) : plain.error();
    if (!tissue.ok() || !held.ok() || !tissue->grab(place, 1.1 * length).ok()) {
        state.SkipWithError("the grab failed");
        return;
    }
    LiveDeformation live = LiveDeformation::create(*tissue).value();
    const double bandwidth = median_bandwidth(arena);
    std::vector<double> drag_ms, resample_ms, items, moved;
    Turns turns(state, "plain loops: a push, and one voxel at a time", arena.thread_count());
    double side = 1, plain_side = 0;
    for (auto _ : state) {
        if (turns.wants_reference()) {
            const auto report = plain->push_elements(*held, (side - plain_side) * out);
            if (report.ok())
                turns.add_reference(
                    (report->solve_ms +
                     deform_volume(*plain, Mapping::CellsScalar).value().resample_ms) *
                    1e-3);
            plain_side = side;
        }
        const auto report = tissue->drag_to(side * out);
        if (!report.ok()) {
            state.SkipWithError("the drag failed");
            return;
        }
        const LiveUpdate update = live.update().value();
        drag_ms.push_back(report->solve_ms);
        resample_ms.push_back(update.resample_ms);
        items.push_back(double(update.written_voxels));
        moved.push_back(double(report->moved_elements));
        turns.add_subject((report->solve_ms + update.resample_ms) * 1e-3);
        side = -side;
    }
    turns.count(median(items));
    state.counters["floor_ns/item"] = kBytesPerVoxel / bandwidth;
    state.counters["moved"] = median(moved);
    state.counters["drag_ms"] = median(drag_ms);
    state.counters["resample_ms"] = median(resample_ms);
    state.counters["resample_ns/voxel"] = median(resample_ms) / median(items) * 1e6;
}

bool register_sizes(const char* name, void (*run)(benchmark::State&)) {
    for (const Size& size : kSizes)
        benchmark::RegisterBenchmark(name, run)
            ->ArgNames({"side", "push", "heterogeneous", "threads"})
            ->ArgsProduct({{size.side}, {size.push}, {0, 1}, {1, 2}})
            ->Iterations(size.turns)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
    return true;
}

const bool registered =
    register_sizes("resample", resample) && register_sizes("whole_frame", whole_frame);

}  // namespace
}  // namespace pliant::bench
