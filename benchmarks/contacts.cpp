// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "contacts.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

#include "interleaved.h"

namespace pliant::bench {
namespace {

constexpr double kFarthest_mm = 500;  ///< no movement limit

struct Size {
    int side;
    double push_mm;
};
constexpr std::array<Size, 5> kHomogeneous = {
    {{40, 3.0}, {60, 6.6}, {104, 14.3}, {200, 31.0}, {410, 67.0}}};
constexpr std::array<Size, 5> kHeterogeneous = {
    {{40, 0.45}, {60, 1.0}, {104, 2.3}, {220, 5.2}, {440, 11.3}}};
constexpr std::array<int, 5> kTurns = {301, 101, 31, 11, 5};

/// Copies memory that exceeds all caches. @returns seconds per byte read or written
double seconds_per_byte(const TaskArena& arena) {
    constexpr std::int64_t kBytes = std::int64_t(96) << 20, kPiece = 1 << 20;
    static std::vector<char> from(std::size_t(kBytes), 1), to(std::size_t(kBytes), 2);
    const double seconds = seconds_of([&] {
        arena.for_each(kBytes, kPiece, [&](std::int64_t begin, std::int64_t end) {
            std::memcpy(to.data() + begin, from.data() + begin, std::size_t(end - begin));
        });
    });
    return seconds / double(2 * kBytes);
}

}  // namespace

Volume layered_volume(int side, bool heterogeneous) {
    Volume volume;
    volume.grid.size = {side, side, side};
    std::vector<std::int16_t> labels(voxel_count(volume.grid), 0);
    if (heterogeneous)
        for (int z = 0; z < side; ++z)
            for (int y = 0; y < side; ++y) {
                const double x_wave = 5 * std::sin(0.2 * y);
                const int yz = int(y + 4 * std::sin(0.3 * z)) / 9 + z / 11;
                for (int x = 0; x < side; ++x)
                    labels[voxel_index(volume.grid, {x, y, z})] =
                        std::int16_t((int(x + x_wave) / 7 + yz) & 3);
            }
    volume.voxels = std::move(labels);
    return volume;
}

std::vector<ElementLimits> limits_of(bool heterogeneous) {
    std::vector<ElementLimits> limits;
    for (const double f :
         heterogeneous ? std::vector<double>{0.02, 0.05, 0.15, 0.4} : std::vector<double>{0.2})
        limits.push_back({{f, f, f}, {f, f, f}, {f, f, f}, kFarthest_mm, false});
    return limits;
}

ChainMailSettings settings_of(bool heterogeneous, ChainMailSolver solver) {
    ChainMailSettings settings;
    // Values below 0 are outside of the scan.
    settings.custom_law = [limits = limits_of(heterogeneous)](int value) {
        return value >= 0
                   ? limits[std::size_t(value) % limits.size()]
                   : ElementLimits{{.2, .2, .2}, {.2, .2, .2}, {.2, .2, .2}, kFarthest_mm, false};
    };
    settings.solver = solver;
    settings.history_max_steps = 0;  // undo has separate rows
    return settings;
}

Contact::Contact(const benchmark::State& state)
    : Contact(int(state.range(0)), state.range(1) != 0, int(state.range(2))) {}

Contact::Contact(int d, bool is_heterogeneous, int thread_count)
    : decade(d), heterogeneous(is_heterogeneous), threads(thread_count) {
    const Size& size = (heterogeneous ? kHeterogeneous : kHomogeneous)[std::size_t(decade)];
    side = size.side;
    push_mm = size.push_mm;
}

Push Contact::diagonal_push() const {
    const double middle = side / 2 + 0.5, along = push_mm / std::sqrt(3.0);
    return {.point_mm = {middle, middle, middle}, .push_mm = {along, along, along}};
}

const Volume& Contact::volume() const {
    static std::optional<Volume> kept;
    static std::pair<int, bool> kept_for;
    const std::pair<int, bool> wanted(side, heterogeneous);
    if (!kept || kept_for != wanted) {
        kept.reset();
        kept.emplace(layered_volume(side, heterogeneous));
        kept_for = wanted;
    }
    return *kept;
}

bool register_contacts(const char* name, Case run, const std::vector<int>& decades) {
    for (const int decade : decades) {
        auto* made = benchmark::RegisterBenchmark(name, run)
                         ->ArgNames({"decade", "heterogeneous", "threads"})
                         ->Iterations(kTurns[std::size_t(decade)])
                         ->UseManualTime()
                         ->Unit(benchmark::kMillisecond);
        // Threads vary fastest, so that cached data of the last case can be reused.
        for (const int heterogeneous : {0, 1})
            for (const int threads : {1, 2}) made->Args({decade, heterogeneous, threads});
    }
    return true;
}

std::int64_t moved_by(const Result<PushReport>& report) {
    if (!report.ok() || report->status != PushStatus::Applied) std::abort();
    return report->moved_elements;
}

void add_floor(benchmark::State& state, const TaskArena& arena, double bytes_per_item) {
    std::vector<double> turns;
    for (int n = 0; n < 5; ++n) turns.push_back(seconds_per_byte(arena));
    const double floor = median(turns) * bytes_per_item * 1e9;
    state.counters["floor_ns/item"] = floor;
    state.counters["times_floor"] = state.counters["ns/item"] / floor;
}

}  // namespace pliant::bench
