// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A drag at 60 Hz across two real scans: the time of each frame, solve and resampling.

#include <pliant/resample.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "chart.h"
#include "figures.h"
#include "setups.h"
#include "timing.h"

namespace pliant::results {
namespace {

constexpr double kFrame_ms = 1000.0 / 60;
constexpr int kFrames = 300;

struct Drag {
    const char* file;
    const char* organ;
    Vec3d place_mm;  ///< where the tool holds the tissue
    double radius_mm;
};

struct Frames {
    std::vector<double> solve_ms, resample_ms, both_ms, moved;
};

/// The tool goes round: out to a radius, then along a circle, once in five seconds.
Vec3d tool_at(int frame) {
    constexpr double kRadius_mm = 12;
    const double angle = 2 * std::numbers::pi * frame / kFrames;
    return kRadius_mm * Vec3d{std::cos(angle), std::sin(angle), 0.4 * std::sin(2 * angle)};
}

Frames run_drag(Scenario& s, const Drag& drag) {
    Frames frames;
    const Grid& grid = s.scan->grid;
    std::vector<Vec3i> held;
    for (int z = 0; z < grid.size.z; ++z)
        for (int y = 0; y < grid.size.y; ++y)
            for (int x = 0; x < grid.size.x; ++x) {
                const Vec3d p = world_from_voxel(grid, {double(x), double(y), double(z)});
                if (norm(p - drag.place_mm) <= drag.radius_mm) held.push_back({x, y, z});
            }
    s.push(held, tool_at(0));
    for (int n = 1; n <= kFrames; ++n) {
        const Vec3d step = tool_at(n) - tool_at(n - 1);
        PushReport report;
        const double solve = milliseconds_of([&] { report = s.push(held, step); });
        const double resample = milliseconds_of([&] { (void)deform_volume(*s.tissue); });
        frames.solve_ms.push_back(solve);
        frames.resample_ms.push_back(resample);
        frames.both_ms.push_back(solve + resample);
        frames.moved.push_back(double(report.moved_elements));
    }
    return frames;
}


Scenario drag_scenario(const std::filesystem::path& file, bool bone_moves, const TaskArena& arena) {
    ChainMailSettings settings;
    settings.offset = 0.1;
    settings.max_movement_mm = 30;
    if (bone_moves) settings.bone_threshold_hu = 4000;
    return make_scenario(must(read_volume(file)), settings, arena);
}

std::vector<std::string> row_for(const Drag& drag, const Frames& f) {
    std::int64_t late = 0;
    for (const double ms : f.both_ms) late += ms > kFrame_ms;
    const auto ms = [](const std::vector<double>& times, double share) {
        return text_of(quantile(times, share), 2);
    };
    return {drag.organ,
            text_of(std::int64_t(quantile(f.moved, 0))),
            text_of(std::int64_t(quantile(f.moved, 0.5))),
            ms(f.solve_ms, 0.5),
            ms(f.resample_ms, 0.5),
            ms(f.both_ms, 0.5),
            ms(f.both_ms, 0.95),
            ms(f.both_ms, 0.99),
            ms(f.both_ms, 1),
            text_of(100.0 * double(late) / double(f.both_ms.size()), 1) + " %"};
}

}  // namespace

void add_drags(Page& page, const std::filesystem::path& scans, const TaskArena& arena) {
    const Drag drags[] = {{"thorax_ct_256.nrrd", "thorax, heart", {0, 130, -590}, 10},
                          {"abdomen_ct_3mm.nii.gz", "abdomen, liver", {-64, -185, 396}, 12}};
    for (const Drag& drag : drags) {
        for (const bool moves : {false, true}) {
            Scenario s = drag_scenario(scans / drag.file, moves, arena);
            const Frames f = run_drag(s, drag);
            double done = 0;
            for (const auto& r : s.reports) done += r.step_fraction / double(s.reports.size());
            std::printf("%s first %.3f mean %.3f:", drag.organ, s.reports[0].step_fraction, done);
            for (const auto& t : row_for(drag, f)) std::printf(" %s |", t.c_str());
            std::printf("\n");
            for (int n = 0; n < 300; n += 30) std::printf(" %g", f.moved[std::size_t(n)]);
            std::printf("\n");
        }
    }
    (void)page;
    (void)histogram;
}

}  // namespace pliant::results
