// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Force against depth under slow pressure.

#include <algorithm>
#include <cmath>
#include <vector>

#include "figures.h"
#include "tissues.h"

namespace pliant::results {
namespace {

/// [mm, N] at 5 mm/s.
std::vector<Point2> press(const HapticTissue& tissue, double deep_mm) {
    HapticSettings settings;
    settings.max_force_n = 7.9;
    settings.max_stiffness_n_m = kDevice_n_m;
    HapticState state;
    state.gain = 1;
    std::vector<Point2> felt;
    for (int k = 0; k <= int(200 * (deep_mm + 0.3)); ++k) {
        const HapticReading reading{1'000'000 * std::int64_t(k), {0, 0, 0.3 - 5e-3 * k}, false, 0};
        HapticModel model;
        if (k % 33 == 0) {
            model = tissue(reading.position_mm);
            model.number = 1 + k / 33;
        }
        servo_step(settings, k % 33 == 0 ? &model : nullptr, reading, state);
        felt.push_back({-reading.position_mm.z, norm(state.force_n)});
    }
    return felt;
}

double stiffness_n_m(const std::vector<Point2>& felt, double low_mm, double high_mm) {
    const auto at = [&](double depth) {
        return *std::lower_bound(felt.begin(), felt.end(), depth,
                                 [](const Point2& p, double d) { return p.x < d; });
    };
    return 1000 * (at(high_mm).y - at(low_mm).y) / (at(high_mm).x - at(low_mm).x);
}

}  // namespace

void add_depth(Page& page, const TaskArena& arena) {
    page.heading(2, "Force against depth");
    page.paragraph(
        "A tool pressed in at 5 mm/s, tissue solved at 30 Hz, a device of 1000 N/m. ChainMail on "
        "scans of soft tissue, with bone 6 mm deep, and of bone; springs with their static "
        "solution; a position-based block. Left: all forces; right: the same curves up to 0.3 N, "
        "beyond which they are cut off. ChainMail on bone 6 mm deep (green) meets that on bone "
        "(wide, dark) at 1 mm and lies on it from there on; ChainMail on soft tissue (wide, blue) "
        "lies under the position-based block: both have 28 N/m in the end.");
    const Axis depth_axis{"depth [mm]", 0, 6, 1};
    Chart charts[] = {{440, 420, depth_axis, {"force [N]", 0, 6, 1}},
                      {440, 420, depth_axis, {"force up to 0.3 N [N]", 0, 0.3, 0.05, 2}}};
    std::vector<std::vector<std::string>> rows;
    struct Pressed {
        const char* name;
        Ink ink;
        std::vector<Point2> felt;
    };
    std::vector<Pressed> all;
    const auto add = [&](const char* name, const HapticTissue& tissue, Ink ink) {
        const std::vector<Point2> felt = press(tissue, 6.2);
        all.push_back({name, ink, felt});
        double fall = 0;
        for (std::size_t k = 1; k < felt.size(); ++k)
            fall = std::max(fall, felt[k - 1].y - felt[k].y);
        rows.push_back({name, fixed_text(stiffness_n_m(felt, 0.2, 1), 1),
                        fixed_text(stiffness_n_m(felt, 5, 6), 1), fixed_text(1000 * fall, 3)});
        return felt;
    };
    add("ChainMail, soft tissue", chainmail(layers(1000), arena), {kBlue, 5});
    add("ChainMail, bone 6 mm deep", chainmail(layers(6), arena), {kGreen, 2});
    add("ChainMail, bone", chainmail(layers(-1), arena), {kDark, 5});
    const std::vector<Point2> felt = add("springs", springs(), {kOrange, 2});
    add("position-based block", pbd(arena), {kRed, 2});
    // Wide curves first: those that lie on them remain visible.
    std::stable_sort(all.begin(), all.end(), [](const Pressed& a, const Pressed& b) {
        return a.ink.width_px > b.ink.width_px;
    });
    for (Chart& chart : charts)
        for (const Pressed& p : all) chart.curve(p.felt, p.ink, p.name);
    double worst = 0;
    std::vector<Point2> statics;
    for (double depth = 0.5; depth < 5.9; depth += 0.25) {
        const double exact = static_force_of_springs_n(depth);
        const auto at = std::lower_bound(felt.begin(), felt.end(), depth,
                                         [](const Point2& p, double d) { return p.x < d; });
        worst = std::max(worst, std::abs(at->y / exact - 1));
        statics.push_back({depth, exact});
    }
    for (Chart& chart : charts) chart.dots(statics, {kDark, 3}, "springs, static solution");
    const Image pictures[] = {charts[0].image(), charts[1].image()};
    page.picture("depth", "force against depth for five tissues", row_of(pictures));
    page.table({"tissue", "stiffness at 0.2…1 mm [N/m]", "at 5…6 mm [N/m]",
                "largest fall from one period to the next [mN]"},
               rows);
    page.paragraph("Springs are off their static solution by at most " +
                   fixed_text(100 * worst, 2) + " % from 0.5 mm on.");
}

}  // namespace pliant::results
