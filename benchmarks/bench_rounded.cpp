// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pushes and drags under rounded limits beside the same ones under those of the box, which move
// fewer elements: times are per moved element of each.

#include <pliant/chainmail.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "contacts.h"
#include "interleaved.h"

namespace pliant::bench {
namespace {

/// The same scan under both limits.
struct TwoTissues {
    TwoTissues(const Volume& volume, ChainMailSettings settings, const TaskArena& arena)
        : boxed(std::move(ChainMail::create(volume, settings, arena)).value()),
          rounded(std::move(ChainMail::create(volume, with_rounded(settings), arena)).value()) {}

    static ChainMailSettings with_rounded(ChainMailSettings settings) {
        settings.limits = LinkLimits::Rounded;
        return settings;
    }
    void reset() {
        boxed.reset();
        rounded.reset();
    }

    ChainMail boxed, rounded;
};

/// A push from rest. About 0.7 times the contact's length, so that it fits into the lattice.
void rounded_contact(benchmark::State& state) {
    const Contact contact(state);
    const TaskArena arena(contact.threads);
    TwoTissues tissues(contact.volume(), settings_of(contact.heterogeneous, ChainMailSolver::Sweep),
                       arena);
    Push push = contact.diagonal_push();
    push.push_mm = 0.7 * push.push_mm;
    const std::int64_t items = moved_by(tissues.rounded.push(push));
    const std::int64_t box_items = moved_by(tissues.boxed.push(push));
    const Turns turns = run_interleaved(
        state, "the box's limits", [&] { tissues.reset(); },
        [&] { moved_by(tissues.rounded.push(push)); }, [&] { moved_by(tissues.boxed.push(push)); },
        arena.thread_count());
    turns.count(double(items), double(box_items));
}

/// Times and moved elements of the steps of a drag.
struct Steps {
    std::vector<double> seconds;
    double moved = 0, largest = 0;

    void drag(ChainMail& tissue, Vec3d offset_mm) {
        seconds.push_back(seconds_of([&] {
            const auto report = tissue.drag_to(offset_mm);
            if (!report.ok()) std::abort();
            moved += double(report->moved_elements);
            largest = std::max(largest, double(report->moved_elements));
        }));
    }
    /// Of all steps together: they differ in their numbers of elements.
    double ns_per_element() const {
        double total = 0;
        for (const double s : seconds) total += s;
        return total / moved * 1e9;
    }
};

/// Steps of a drag, each as a command of its own; the drag starts again after the last one. The box
/// has precomputed fields.
void drag_in_steps(benchmark::State& state, const Volume& volume, const ChainMailSettings& settings,
                   const Push& tool, Vec3d step_mm, int step_count) {
    const TaskArena arena(int(state.range(0)));
    TwoTissues tissues(volume, settings, arena);
    constexpr double kReach_mm = 20;
    Steps rounded, boxed;
    int step = 0;
    Turns turns(state, "the box's limits", arena.thread_count());
    for (auto _ : state) {
        if (step++ % step_count == 0) {
            step = 1;
            tissues.reset();
            if (!tissues.rounded.grab(tool, kReach_mm).ok() ||
                !tissues.boxed.grab(tool, kReach_mm).ok())
                return state.SkipWithError("nothing to grab");
        }
        boxed.drag(tissues.boxed, double(step) * step_mm);
        turns.add_reference(boxed.seconds.back());
        rounded.drag(tissues.rounded, double(step) * step_mm);
        turns.add_subject(rounded.seconds.back());
    }
    const double count = double(rounded.seconds.size());
    turns.count(rounded.moved / count, boxed.moved / count);
    state.counters["ns/item"] = rounded.ns_per_element();
    state.counters["reference_ns/item"] = boxed.ns_per_element();
    state.counters["times_faster"] = boxed.ns_per_element() / rounded.ns_per_element();
    state.counters["largest_items"] = rounded.largest;
    state.counters["median_ms"] = median(rounded.seconds) * 1e3;
    state.counters["worst_ms"] =
        *std::max_element(rounded.seconds.begin(), rounded.seconds.end()) * 1e3;
}

ChainMailSettings soft_settings() {
    ChainMailSettings settings;
    settings.bone_threshold_hu = 3000;
    settings.max_movement_mm = 500;
    settings.history_max_steps = 0;
    return settings;
}

/// A tool in the chest of a CT. Argument: threads.
void rounded_drag_thorax(benchmark::State& state) {
    const char* folder = std::getenv("PLIANT_SHARED_DATA");
    const auto scan =
        read_volume(std::string(folder ? folder : "../shared/data") + "/thorax_ct_256.nrrd");
    if (!scan.ok())
        return state.SkipWithError("the scan is not there; PLIANT_SHARED_DATA says where it is");
    const Push tool{.point_mm = world_from_voxel(scan->grid, {128, 90, 68}), .sphere_radius_mm = 4};
    drag_in_steps(state, *scan, soft_settings(), tool, {0.6, 0.8, 0.5}, 12);
}

/// A scan of 512×512×600 of many values, in which the last steps move millions of elements.
void rounded_drag_large(benchmark::State& state) {
    Volume volume;
    volume.grid.size = {512, 512, 600};
    volume.grid.spacing_mm = {0.7, 0.7, 0.6};
    std::vector<std::int16_t> values(voxel_count(volume.grid));
    for (std::size_t n = 0, row = 0; n < values.size(); ++row) {
        const int y = int(row % 512), z = int(row / 512);
        const double wave = 30 * std::cos(0.07 * y + 0.05 * z);
        for (int x = 0; x < 512; ++x, ++n)
            values[n] = std::int16_t(40 + wave + (x * 7 + y * 13 + z * 5) % 23 -
                                     (x / 60 + y / 70 + z / 80) % 3 * 100);
    }
    volume.voxels = std::move(values);
    const Push tool{.point_mm = {180, 180, 180}, .sphere_radius_mm = 6};
    drag_in_steps(state, volume, soft_settings(), tool, {0.7, 0.9, 0.6}, 12);
}

const bool registered = register_contacts("rounded_contact", rounded_contact, {1, 3, 4});

BENCHMARK(rounded_drag_thorax)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(36);
BENCHMARK(rounded_drag_large)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(12);

}  // namespace
}  // namespace pliant::bench
