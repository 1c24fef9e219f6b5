// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes the page that compares mass-spring networks and force transmittal with their paper:
//
//   results_springs FOLDER SCANS [PART…]
//
// FOLDER gets README.md and its pictures; SCANS may have the scans of shared/data; parts are point,
// depth, orders, responses, scan, touched, identification, fibres and timings, by default all.
// Pictures and errors are reproducible; times are not.

#include <pliant/core/tasks.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

#include "figures.h"

namespace {

void add_introduction(pliant::results::Page& page) {
    using namespace pliant::results;
    page.heading(1, "Force transmittal beside its paper");
    page.paragraph(
        "Figures 8 to 13 and 15 and tables 1 to 3 of [Choi2004], and what Pliant does on the same "
        "set-up "
        "or, where the paper doesn't name it, on one that is named here. The models are described "
        "in [springs.md](../../method/springs.md) and [fem.md](../../method/fem.md), "
        "identification "
        "in [fit.md](../../method/fit.md). The paper's own pictures are not repeated: the text "
        "says "
        "what they show.");
    page.origin("./dev results springs");
}

void add_differences(pliant::results::Page& page) {
    page.heading(2, "What differs from the paper, and why");
    page.paragraph(
        "* **What isn't said.** Diagonals or not, masses, time step, when a run stops, whether a "
        "force is meant for each node or in total, its direction, the annealing's bounds, "
        "neighbours and number of evaluations, sizes and limits of figures 9 to 12. Each choice is "
        "named where it is made.\n"
        "* **Figure 10's explanation contradicts the figure** (see there): for the same force and "
        "an absolute threshold, a stiffer lattice needs fewer layers at its equilibrium. Stopping "
        "after a fixed time gives the figure's 4, 6 and 8.\n"
        "* **Damping can't be found from equilibria.** The paper's 2149 is no property of elastin; "
        "it can only mean something if runs were stopped before their end.\n"
        "* **Table 2's errors grow with the force** because everything is linear in it, and not "
        "because large deformations are harder to follow: 2.7, 5.4 and 10.9 % are 0.27 % for each "
        "newton. What large deformations really change is in the rows for springs at equilibrium.\n"
        "* **A model that doesn't move at all** would have an error of 0.71 to 17.7 % at 10 N, by "
        "reading. Where a fit isn't far below that it has failed, whatever its error looks like.");
}

}  // namespace

int main(int argc, char** argv) {
    using namespace pliant::results;
    if (argc < 3) {
        std::fprintf(stderr, "results: expected a folder to write to, one with scans, and parts\n");
        return 2;
    }
    const pliant::TaskArena arena;
    const std::pair<std::string_view, std::function<void(Page&)>> parts[] = {
        {"point", [&](Page& page) { add_touch_point(page, arena); }},
        {"depth", [&](Page& page) { add_depth(page, arena); }},
        {"orders", [&](Page& page) { add_orders(page); }},
        {"responses", [&](Page& page) { add_responses(page, arena); }},
        {"scan", [&](Page& page) { add_scans(page, argv[2], arena); }},
        {"touched", [&](Page& page) { add_touched(page, argv[2], arena); }},
        {"identification", [&](Page& page) { add_identification(page, arena); }},
        {"fibres", [&](Page& page) { add_fibres(page, arena); }},
        {"timings", [&](Page& page) { add_timings(page, arena); }}};
    const std::vector<std::string_view> wanted(argv + 3, argv + argc);
    Page page{argv[1]};
    add_introduction(page);
    for (const auto& [name, add] : parts)
        if (wanted.empty() || std::count(wanted.begin(), wanted.end(), name) > 0) add(page);
    add_differences(page);
    if (const pliant::Status status = page.finish(); !status.ok()) {
        std::fprintf(stderr, "results: %s\n", status.error().message.c_str());
        return 1;
    }
}
