// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The path through a lumen, as a curve for 3D Slicer, `pliant render --path` and the page.

#include <pliant/render.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "camera_path.h"
#include "options.h"
#include "progress.h"
#include "scan_defaults.h"
#include "setting_options.h"

namespace pliant::app {
namespace {

void tell(const PathOptions& o, const LumenPath& path) {
    const auto [narrow, wide] = std::minmax_element(path.radius_mm.begin(), path.radius_mm.end());
    const double mean = std::accumulate(path.radius_mm.begin(), path.radius_mm.end(), 0.0) /
                        double(path.radius_mm.size());
    if (o.json) {
        const nlohmann::ordered_json report = {
            {"points", path.points_mm.size()}, {"length_mm", path.length_mm},
            {"radius_min_mm", *narrow},        {"radius_mean_mm", mean},
            {"radius_max_mm", *wide},
        };
        std::printf("%s\n", report.dump().c_str());
        return;
    }
    std::printf("%s: %.1f mm, %zu points, radius %.1f…%.1f mm\n", o.out.c_str(), path.length_mm,
                path.points_mm.size(), *narrow, *wide);
}

}  // namespace

int run_path(const PathOptions& o) {
    LumenPathSettings settings;
    settings.reach_mm = o.reach_mm;
    std::optional<ProgressBar> bar(std::in_place, "path");
    ReadNotes notes;
    auto volume = read_volume(o.file, o.scan.options(), &notes);
    if (!volume) {
        bar.reset();
        return bad_input(volume.error());
    }
    const ValueDefaults values = take_values(*volume, notes);
    settings.spacing_mm =
        o.spacing_mm.value_or(length_scale(volume->grid) * LumenPathSettings{}.spacing_mm);
    settings.iso_hu = o.iso_hu.value_or(values.iso);
    settings.polarity = polarity_of(o.polarity, values);
    const TaskArena arena(o.threads);
    const auto path = find_lumen_path(*volume, o.from_mm, o.to_mm, settings, arena);
    bar.reset();
    if (!path) return bad_input(named_by_option(path.error()).message);
    if (path->points_mm.size() < 2)
        return bad_input("--from, --to: expected two different positions, found one");
    if (const Status s = write_camera_path(o.out, path->points_mm, path->radius_mm); !s)
        return bad_input(s.error());
    tell(o, *path);
    return kExitOk;
}

}  // namespace pliant::app
