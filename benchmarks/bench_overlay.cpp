// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cost of an overlay per frame: soft tissue of a CT is pushed to and fro, as in
// viewer/test/measure_latency.ts. Two live deformations follow it alternately, one with sources and
// one without. The overlay is computed for the changed bricks, as for sending. Reference: the frame
// without an overlay.

#include <pliant/chainmail.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>

#include <cstdlib>

#include "interleaved.h"

namespace pliant::bench {
namespace {

std::string scan_file() {
    const char* folder = std::getenv("PLIANT_SHARED_DATA");
    return std::string(folder ? folder : "../shared/data") + "/thorax_ct_256.nrrd";
}

/// Arguments: radius of the pushed sphere [mm]; threads.
void overlay_frame(benchmark::State& state) {
    const TaskArena arena(int(state.range(1)));
    auto scan = read_volume(scan_file());
    if (!scan.ok()) {
        state.SkipWithError("the scan is not there; PLIANT_SHARED_DATA says where it is");
        return;
    }
    ChainMailSettings settings;
    settings.bone_threshold_hu = 30'000;
    settings.max_movement_mm = 200;
    auto tissue = ChainMail::create(*scan, settings, arena);
    if (!tissue.ok()) {
        state.SkipWithError("no lattice");
        return;
    }
    const Vec3i n = scan->grid.size;
    const Vec3d middle = world_from_voxel(scan->grid, {0.5 * n.x, 0.62 * n.y, 0.5 * n.z});
    constexpr double kPush = 9;
    LiveDeformation plain = LiveDeformation::create(*tissue).value();
    LiveDeformation kept = LiveDeformation::create(*tissue).value();
    if (!kept.keep_sources(true)) {
        state.SkipWithError("no memory");
        return;
    }
    std::vector<double> solve_ms, plain_ms, kept_ms, displacement_ms, jacobian_ms, moved, voxels;
    std::vector<float> values;
    Turns turns(state, "without an overlay");
    int turn = 0;
    for (auto _ : state) {
        const double side = turn % 2 ? -kPush : kPush;
        const Vec3d point = middle + Vec3d{turn % 2 ? kPush : 0, 0, 0};
        const auto report = tissue->push({.point_mm = point,
                                          .push_mm = {side, 0, 0},
                                          .sphere_radius_mm = double(state.range(0))});
        if (!report.ok()) {
            state.SkipWithError("the push failed");
            return;
        }
        // The second one finds the lattice in the caches.
        double without = 0, with = 0;
        LiveUpdate update;
        const auto run_plain = [&] { without = plain.update().value().resample_ms; };
        const auto run_kept = [&] { with = (update = kept.update().value()).resample_ms; };
        if (turn % 4 < 2)
            run_plain(), run_kept();
        else
            run_kept(), run_plain();
        ++turn;
        double count = 0, displacement = 0, jacobian = 0;
        for (const Box3i& box : update.boxes) {
            const Vec3i size = box.end - box.begin;
            values.resize(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
            count += double(values.size());
            displacement += seconds_of([&] { kept.displacement_mm(box, values); }) * 1e3;
            jacobian += seconds_of([&] { kept.jacobian(box, values); }) * 1e3;
        }
        solve_ms.push_back(report->solve_ms);
        plain_ms.push_back(without);
        kept_ms.push_back(with);
        displacement_ms.push_back(displacement);
        jacobian_ms.push_back(jacobian);
        moved.push_back(double(report->moved_elements));
        voxels.push_back(count);
        turns.add_reference((report->solve_ms + without) * 1e-3);
        turns.add_subject((report->solve_ms + with + jacobian) * 1e-3);
    }
    turns.count(median(voxels));
    state.counters["moved"] = median(moved);
    state.counters["solve_ms"] = median(solve_ms);
    state.counters["resample_ms"] = median(plain_ms);
    state.counters["with_sources_ms"] = median(kept_ms);
    state.counters["displacement_ms"] = median(displacement_ms);
    state.counters["jacobian_ms"] = median(jacobian_ms);
}

BENCHMARK(overlay_frame)
    ->ArgNames({"radius", "threads"})
    ->ArgsProduct({{10, 25}, {1, 2}})
    ->Iterations(60)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
