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

}  // namespace
}  // namespace pliant::results
