// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The solve and the way back to the grid, on a block of tissue with no bone and no border near by,
// so that the motion spreads as far as the limits let it. Times are those of the reports; setting
// up is not counted. Compare figures of one run with each other: machines differ, and are shared.

#include <benchmark/benchmark.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <cstdint>

namespace {

using namespace pliant;

constexpr int kSide = 176;  ///< voxels of 1 mm

/// Blobs of 8³ voxels with values between fat and dense tissue, or all alike.
Volume block_of_tissue(bool heterogeneous) {
    Volume volume;
    volume.grid.size = {kSide, kSide, kSide};
    std::vector<std::int16_t> voxels(voxel_count(volume.grid), 40);
    for (int z = 0; heterogeneous && z < kSide; ++z)
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                std::uint32_t h = std::uint32_t((z / 8 * 64 + y / 8) * 64 + x / 8);
                h = (h ^ (h >> 16)) * 0x7feb352du;
                h = (h ^ (h >> 15)) * 0x846ca68bu;
                voxels[voxel_index(volume.grid, {x, y, z})] = std::int16_t(h % 1200) - 100;
            }
    volume.voxels = std::move(voxels);
    return volume;
}

/// A push from the middle of the block that moves about a million elements.
ChainMailSettings far_reaching(ChainMailSolver solver) {
    return {.offset = 0.1, .bone_threshold_hu = 3000, .max_movement_mm = 500, .solver = solver};
}
constexpr Push kPush = {.point_mm = {kSide / 2.0, kSide / 2.0, kSide / 2.0},
                        .push_mm = {7, 0, 0},
                        .sphere_radius_mm = 4};

void push(benchmark::State& state, ChainMailSolver solver, bool heterogeneous, int threads) {
    const Volume volume = block_of_tissue(heterogeneous);
    const TaskArena arena(threads);
    double moved = 0, seconds = 0;
    for (auto _ : state) {
        auto tissue = ChainMail::create(volume, far_reaching(solver), arena);
        const auto report = tissue.ok() ? tissue->push(kPush) : tissue.error();
        if (!report.ok() || report->status != PushStatus::Applied) {
            state.SkipWithError("the push was not applied");
            return;
        }
        moved += double(report->moved_elements);
        seconds += report->solve_ms / 1000;
        state.SetIterationTime(report->solve_ms / 1000);
    }
    state.counters["moved"] = moved / double(state.iterations());
    state.counters["ns_per_moved"] = 1e9 * seconds / moved;
}

void map_to_grid(benchmark::State& state, Mapping mapping, int threads) {
    const Volume volume = block_of_tissue(true);
    const TaskArena arena(threads);
    auto tissue = ChainMail::create(volume, far_reaching(ChainMailSolver::Sweep), arena);
    const auto report = tissue.ok() ? tissue->push(kPush) : tissue.error();
    if (!report.ok() || report->status != PushStatus::Applied) {
        state.SkipWithError("the push was not applied");
        return;
    }
    double written = 0, seconds = 0;
    for (auto _ : state) {
        const Deformed deformed = deform_volume(*tissue, mapping);
        written += double(deformed.written_voxels);
        seconds += deformed.resample_ms / 1000;
        state.SetIterationTime(deformed.resample_ms / 1000);
    }
    state.counters["written"] = written / double(state.iterations());
    state.counters["ns_per_voxel"] = 1e9 * seconds / written;
}

#define PLIANT_BENCHMARK(...) \
    BENCHMARK_CAPTURE(__VA_ARGS__)->UseManualTime()->Unit(benchmark::kMillisecond)
PLIANT_BENCHMARK(push, heterogeneous_heap, ChainMailSolver::Heap, true, 1);
PLIANT_BENCHMARK(push, heterogeneous_sweep_1_thread, ChainMailSolver::Sweep, true, 1);
PLIANT_BENCHMARK(push, heterogeneous_sweep_all_threads, ChainMailSolver::Sweep, true, 0);
PLIANT_BENCHMARK(push, homogeneous_heap, ChainMailSolver::Heap, false, 1);
PLIANT_BENCHMARK(push, homogeneous_sweep_1_thread, ChainMailSolver::Sweep, false, 1);
PLIANT_BENCHMARK(push, homogeneous_sweep_all_threads, ChainMailSolver::Sweep, false, 0);
PLIANT_BENCHMARK(map_to_grid, cells_1_thread, Mapping::Cells, 1);
PLIANT_BENCHMARK(map_to_grid, cells_all_threads, Mapping::Cells, 0);
PLIANT_BENCHMARK(map_to_grid, tetrahedra_all_threads, Mapping::Tetrahedra, 0);

}  // namespace
