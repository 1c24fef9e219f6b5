// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Draeger2005, 6.1]: the tables of timings, those of 2005 and ours for as many moved elements.

#include <pliant/resample.h>

#include "figures.h"
#include "setups.h"
#include "timing.h"

namespace pliant::results {
namespace {

constexpr int kRuns = 301;

struct Times {
    std::vector<double> solve_ms, resample_ms, both_ms;
};

/// New tissue for each push: creation of bricks is part of the push, like loading in the thesis.
Times time_pushes(const TimingCase& timing, const TaskArena& arena) {
    Times times;
    for (int n = 0; n < kRuns; ++n) {
        Scenario s = timing_scenario(timing, 8, arena);
        const Push push = timing_push(s);
        LiveDeformation live = LiveDeformation::create(*s.tissue).value();
        const double solve = milliseconds_of([&] { s.push(push); });
        const double resample = milliseconds_of([&] { (void)live.update(); });
        times.solve_ms.push_back(solve);
        times.resample_ms.push_back(resample);
        times.both_ms.push_back(solve + resample);
    }
    return times;
}

void add_cubicles(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 6.1: loading a cubicle");
    page.paragraph(
        "The thesis loads cubicles of n³ elements; Pliant makes bricks of n³ elements when "
        "something in them moves. Timed is a push of one element that reaches no other: in a fresh "
        "lattice, where it makes its brick, and once more, where the brick is there. Medians of " +
        grouped_text(std::int64_t(kRuns)) + " turns.");
    const double times_2005[] = {1.062,  4.657,  12.698, 31.755, 66.176,
                                 132.35, 248.29, 446.81, 740.36, 1156};
    std::vector<std::vector<std::string>> rows;
    for (int size = 3; size <= 12; ++size) {
        std::vector<double> first, second;
        for (int n = 0; n < kRuns; ++n) {
            Scenario s = timing_scenario(timing_cases()[0], size, arena);
            const std::vector<Vec3i> element{
                {2 * size + size / 2, 2 * size + size / 2, size + size / 2}};
            first.push_back(milliseconds_of([&] { s.push(element, {0, 0.1, 0}); }));
            second.push_back(milliseconds_of([&] { s.push(element, {0, 0.1, 0}); }));
        }
        const double a = quantile(first, 0.5), b = quantile(second, 0.5);
        rows.push_back({std::to_string(size), fixed_text(times_2005[size - 3], 3), fixed_text(a, 4),
                        fixed_text(b, 4)});
    }
    page.table({"size n", "2005: load [ms]", "first push [ms]", "second push [ms]"}, rows);
}

}  // namespace

void add_timings(Page& page, const TaskArena& arena) {
    page.heading(2, "Dräger 2005, chapter 6: timings");
    page.paragraph(
        "His machine was a notebook with a Centrino of 1.6 GHz, Java 1.4.2 and cubicles of 3³. "
        "Ours is named above, with bricks of 8³.");
    add_cubicles(page, arena);
    page.heading(3, "Figure 6.2: deformation and mapping");
    page.paragraph(
        "The numbers of moved elements tell what was pushed: slices 2.22 to 2.25 pixels apart (the "
        "thesis says 2.2) and links of exactly the offset, without the factor for the value. "
        "Pliant "
        "then moves the same numbers. Only where the push is a whole multiple of the offset does "
        "rounding decide whether the outermost elements count: they move by nanometres here; the "
        "column beside it has those that moved by more than a micrometre. The row with the scale "
        "factor 1.2 is from the text below the figure. Medians of " +
        grouped_text(std::int64_t(kRuns)) +
        " fresh lattices in a scan of 64 × 64 × 32 voxels; mapping is the first update of a "
        "deformed scan that is at hand as a copy of the original.");
    std::vector<std::vector<std::string>> rows;
    for (const TimingCase& timing : timing_cases()) {
        Scenario s = timing_scenario(timing, 8, arena);
        s.push(timing_push(s));
        const Times t = time_pushes(timing, arena);
        const double both = quantile(t.both_ms, 0.5);
        rows.push_back(
            {fixed_text(timing.offset, 2), fixed_text(timing.scale, 1),
             grouped_text(timing.elements_2005), grouped_text(s.reports[0].moved_elements),
             grouped_text(visibly_moved(*s.tissue)),
             fixed_text(timing.deform_2005_ms, 0) + " + " + fixed_text(timing.map_2005_ms, 0),
             fixed_text(quantile(t.solve_ms, 0.5), 3), fixed_text(quantile(t.resample_ms, 0.5), 3),
             fixed_text(both, 3), fixed_text(quantile(t.both_ms, 0.95), 3)});
    }
    page.table({"offset", "scale", "moved, 2005", "moved", "by > 1 µm", "2005 [ms]", "solve [ms]",
                "resample [ms]", "both [ms]", "both, p95 [ms]"},
               rows);
}

}  // namespace pliant::results
